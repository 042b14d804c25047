#include <random>

#include <gtest/gtest.h>

#include "gvx/io/dicom_test_support.h"
#include "gvx/io/volume_test_support.h"

namespace gvx::io::test {
namespace {

/// A good file of 24 samples of type i16, big-endian, and where its header ends.
struct Specimen {
  std::string extension;
  std::string bytes;
  std::size_t header_bytes = 0;
};

Specimen specimen(std::string extension, const std::string& header, const std::string& data) {
  return {std::move(extension), header + data, header.size()};
}

std::string nifti_header() {
  std::string bytes(352, '\0');
  const auto set = [&](std::size_t offset, auto value) {
    bytes_of(value, true).copy(bytes.data() + offset, sizeof value);
  };
  set(0, std::int32_t{348});
  for (std::size_t i = 0; const int length : {3, 4, 3, 2, 1, 1, 1, 1})
    set(40 + 2 * i++, static_cast<std::int16_t>(length));
  set(70, std::int16_t{4});
  set(72, std::int16_t{16});
  set(108, 352.0f);
  set(112, 2.0f);
  set(252, std::int16_t{1});
  set(254, std::int16_t{1});
  for (const std::size_t diagonal : {280, 300, 320}) set(diagonal, 1.5f);
  bytes.replace(344, 3, "n+1");
  return bytes;
}

/// A data set of two frames, up to its pixels.
std::string dicom_header(bool big_endian) {
  DicomWriter frames = dicom_slice(1, {1, 2, 3}, DicomWriter(true, big_endian)).text(0x00280008, "IS", "2");
  frames.sequence(0x00081140, {DicomWriter(true, big_endian).text(0x00081155, "UI", "1.2")});
  std::string bytes = frames.element(kPixelData, "OW", std::string(48, '\0')).bytes();
  bytes.resize(bytes.size() - 48);
  return bytes;
}

std::vector<Specimen> specimens() {
  constexpr int kGzip = 15 + 16, kZlib = 15;
  const std::string data = small_samples(SampleType::i16, true);
  std::string text;
  for (int i = 0; i < 24; ++i) text += std::to_string(small_sample<std::int16_t>(i)) + "\n";
  const std::string nrrd =
      "NRRD0004\ntype: int16\ndimension: 3\nsizes: 4 3 2\nspace: LPS\nspace directions: (1,0,0) (0,1,0) "
      "(0,0,1)\n"
      "kinds: domain domain domain\nspace origin: (0,0,0)\nendian: big\nbyte skip: 0\nencoding: ";
  const std::string meta =
      "NDims = 3\nDimSize = 4 3 2\nElementType = MET_SHORT\nBinaryDataByteOrderMSB = True\nHeaderSize = 0\n"
      "ElementSpacing = 1 1 2\nOffset = 0 0 0\nTransformMatrix = 1 0 0 0 1 0 0 0 1\nBinaryData = ";
  const std::string local = "ElementDataFile = LOCAL\n";
  const std::string little = small_samples(SampleType::i16, false);
  return {
      specimen(".dcm", DicomWriter::file(kBigEndian, dicom_header(true)), data),
      specimen(".dcm", DicomWriter::file(kDeflated, deflated(dicom_header(false) + little, -15)), ""),
      specimen(".nrrd", nrrd + "raw\n\n", data),
      specimen(".nrrd", nrrd + "gzip\n\n", deflated(data, kGzip)),
      specimen(".nrrd", nrrd + "bzip2\n\n", bzipped(data)),
      specimen(".nrrd", nrrd + "ascii\n\n", text),
      specimen(".mha", meta + "True\n" + local, data),
      specimen(".mha", meta + "False\n" + local, text),
      specimen(".mha", meta + "True\nCompressedData = True\n" + local, deflated(data, kZlib)),
      specimen(".nii", nifti_header(), data),
      specimen(".nii.gz", "", deflated(nifti_header() + data, kGzip)),
      specimen("_4x3x2_i16_be.raw", "", data),
      specimen("_4x3x2_i16_be.raw.gz", "", deflated(data, kGzip)),
      specimen("_4x3x2_i16_be.raw.bz2", "", bzipped(data)),
  };
}

std::string temporary(const Specimen& specimen) {
  return temporary_path("specimen" + specimen.extension);
}

TEST(HostileVolumes, specimens_are_good) {
  for (const Specimen& good : specimens()) {
    write_file(temporary(good), good.bytes);
    const auto samples = load(temporary(good));
    ASSERT_TRUE(samples.ok()) << outcome(samples);
    EXPECT_EQ(samples.value(), native_small_samples(SampleType::i16)) << good.extension;
  }
}

TEST(HostileVolumes, every_truncation_is_an_error_or_the_samples) {
  for (const Specimen& good : specimens()) {
    const std::string path = temporary(good);
    int errors = 0;
    for (std::size_t size = 0; size < good.bytes.size(); ++size) {
      write_file(path, good.bytes.substr(0, size));
      const auto samples = load(path);
      if (!samples.ok()) {
        ++errors;
        EXPECT_EQ(samples.error().message.rfind(path, 0), 0u) << samples.error().message;
      } else if (good.bytes.find("encoding: ascii") == std::string::npos &&
                 good.bytes.find("BinaryData = False") == std::string::npos) {
        EXPECT_EQ(samples.value(), native_small_samples(SampleType::i16))
            << good.extension << " cut to " << size;
      } else {
        // Text whose last number lost a digit is still text of 24 numbers.
        EXPECT_EQ(samples.value().substr(0, 46), native_small_samples(SampleType::i16).substr(0, 46));
      }
    }
    // Of packed samples the last 16 bytes may be all checksum.
    EXPECT_GE(errors, static_cast<int>(good.bytes.size()) - 16) << good.extension;
  }
}

TEST(HostileVolumes, flipped_bits_never_break_the_reader) {
  std::mt19937 random(20240607);
  int errors = 0, successes = 0;
  for (const Specimen& good : specimens()) {
    const std::string path = temporary(good);
    const std::size_t reach = good.header_bytes != 0 ? good.header_bytes : good.bytes.size();
    for (int round = 0; round < 1000; ++round) {
      std::string bytes = good.bytes;
      for (int flip = 0; flip <= round % 4; ++flip) {
        char& c = bytes[random() % reach];
        c = static_cast<char>(round % 3 == 0 ? random() : static_cast<unsigned>(c) ^ (1u << random() % 8));
      }
      write_file(path, bytes);
      const auto samples = load(path, {}, 1 << 20);
      ++(samples.ok() ? successes : errors);
      if (!samples.ok()) {
        EXPECT_EQ(samples.error().message.find('\n'), std::string::npos) << samples.error().message;
      }
    }
  }
  EXPECT_GT(errors, 3000);
  EXPECT_GT(successes, 100);
}

TEST(HostileVolumes, junk_of_every_extension) {
  std::mt19937 random(7);
  for (const char* extension :
       {".nrrd", ".nhdr", ".mha", ".mhd", ".nii", ".nii.gz", ".hdr", ".img", ".dcm"}) {
    const std::string path = temporary_path(std::string("junk") + extension);
    std::string junk(3 << 20, '\0');
    for (char& c : junk) c = static_cast<char>(random());
    for (const std::string& magic : {std::string(), std::string("NRRD0004\n"), std::string("a = b\n")}) {
      write_file(path, magic + junk);
      EXPECT_FALSE(load(path).ok()) << path;
    }
  }
}

}  // namespace
}  // namespace gvx::io::test
