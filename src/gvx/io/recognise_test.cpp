#include "gvx/io/recognise.h"

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>

#include <gtest/gtest.h>

#include "gvx/io/format_table.h"
#include "gvx/io/volume_reader.h"

namespace gvx::io {
namespace {

using namespace std::string_view_literals;
namespace fs = std::filesystem;

class Recognise : public testing::Test {
 protected:
  void SetUp() override {
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  std::string path(const std::string& name) const { return folder_ + "/" + name; }
  std::string write(const std::string& name, std::string_view bytes) const {
    fs::create_directories(fs::path(path(name)).parent_path());
    std::ofstream(path(name), std::ios::binary) << bytes;
    return path(name);
  }
  /// What opening it as a volume says.
  static std::string problem(const std::string& path, const RawOptions& raw = {}) {
    const auto opened = open_volume(path, raw);
    return opened.ok() ? "" : opened.error().message;
  }

 private:
  std::string folder_ = testing::TempDir() + "recognise";
};

std::string at(std::size_t place, std::string_view bytes, std::size_t size = 512) {
  std::string file(size, '\1');
  return file.replace(place, bytes.size(), bytes);
}

TEST_F(Recognise, first_bytes_tell_more_than_the_name) {
  const struct {
    std::string bytes;
    const char* part;
  } cases[] = {{at(0, "\x89HDF\r\n\x1a\n"), "HDF5 is not read yet"},
               {at(512, "\x89HDF\r\n\x1a\n", 1024), "HDF5 is not read yet"},
               {at(0, "\x89PNG\r\n\x1a\n"), "PNG picture is one slice"},
               {at(208, "MAP "), "MRC density map is not read yet"},
               {at(0, "II*\0"sv), "TIFF"},
               {at(0, "MM\0*"sv), "TIFF"},
               {at(0, "\x93NUMPY"), "NumPy array is not read yet"},
               {at(257, "ustar"), "tar archive"},
               {"<?xml version=\"1.0\"?>\n<VTKFile type=\"ImageData\">", "VTK image data is not read yet"},
               {"<VTKFile type=\"PImageData\" version=\"0.1\">", "VTK image data is not read yet"},
               {"<VTKFile type=\"UnstructuredGrid\">", "VTK grid is not read yet"},
               {"# vtk DataFile Version 3.0\n", "legacy VTK file"},
               {"{\"volume\": \"a.gvx\"}", "gvx render takes a scene file"},
               {"x,y,z\n1,2,3\n", "Text is neither"},
               {"GVXSTORE", "found a gvx store"},
               {"ply\nformat ascii 1.0\n", "found a mesh"},
               {"", "is empty"}};
  for (const auto& [bytes, part] : cases) {
    for (const char* name : {"file", "file.nrrd", "file.mha", "file.xyz123", "file.dat"}) {
      // Of text the name tells more.
      const bool text = !bytes.empty() && (bytes[0] == '{' || bytes[0] == 'x');
      if (text && std::string_view(name).starts_with("file.") && !std::string_view(name).ends_with("123"))
        continue;
      const std::string file = write(name, bytes);
      const std::string message = problem(file);
      EXPECT_EQ(message.rfind(file + ": ", 0), 0u) << message;
      EXPECT_NE(message.find(part), std::string::npos) << name << ": " << message;
    }
  }
}

TEST_F(Recognise, names_tell_where_first_bytes_do_not) {
  for (const auto& [name, part] : {std::pair{"a.mgz", "FreeSurfer"},
                                   {"a.VTI", "VTK image data"},
                                   {"a.vdb", "OpenVDB"},
                                   {"a.csv", "table"},
                                   {"a.map.gz", "MRC"},
                                   {"a.las", "point cloud"},
                                   {"a.off", "OFF mesh"},
                                   {"a.czi", "CZI"}}) {
    const std::string message = problem(write(name, "\1\2\3 no mark"));
    EXPECT_NE(message.find(part), std::string::npos) << message;
    EXPECT_NE(message.find("; "), std::string::npos) << message;
  }
  EXPECT_NE(problem(write("a.foo", "\1\2\3")).find("not a file that gvx knows"), std::string::npos);
  EXPECT_NE(problem(path("none.vti")).find("cannot open"), std::string::npos);
}

TEST_F(Recognise, what_is_read_is_read_whatever_its_name) {
  const std::string nrrd = "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 2 1 1\nencoding: raw\n\nab";
  EXPECT_EQ(problem(write("brain", nrrd)), "");
  EXPECT_EQ(problem(write("brain.nii", nrrd)), "");
  EXPECT_EQ(recognise(write("brain.raw", nrrd)).kind, FileKind::nrrd);
}

TEST_F(Recognise, samples_may_begin_with_any_bytes_where_their_shape_is_given) {
  const std::string samples = at(0, "\x89HDF\r\n\x1a\n");
  EXPECT_EQ(problem(write("a_8x8x8_uint8.raw", samples)), "");
  const RawOptions shape{.dimensions = Vec3i(8, 8, 8), .type = SampleType::u8};
  EXPECT_EQ(problem(write("a.h5", samples), shape), "");
  EXPECT_EQ(problem(write("a", samples), shape), "");
  EXPECT_NE(problem(write("a.raw", samples)).find("HDF5"), std::string::npos);
  EXPECT_NE(problem(write("b.raw", at(0, "x"))).find("dimensions: expected"), std::string::npos);
}

TEST_F(Recognise, a_folder_is_what_is_in_it) {
  for (int i = 0; i < 5; ++i) {
    const std::string number = std::to_string(i);
    write("pictures/" + number + ".png", at(0, "\x89PNG\r\n\x1a\n"));
    write("series/IM" + number, at(128, "DICM"));
    write("tiff/" + number + ".tif", at(0, "II*\0"sv));
  }
  write("series/notes.txt", "notes");
  write("nifti/a.nii", "x");
  write("nifti/b.nii.gz", "x");
  write("nifti/b.json", "{}");
  write("image.zarr/.zgroup", "{}");
  write("v3/zarr.json", "{}");
  write("n5/attributes.json", "{}");
  write("outer/image.zarr/.zgroup", "{}");
  write("outer2/README.txt", "text");
  write("outer2/series/IM1", "x");
  write("outer2/tiff/1.tif", "x");
  fs::create_directories(path("nothing"));
  const auto expect = [&](const char* folder, const char* part) {
    const std::string message = problem(path(folder));
    EXPECT_NE(message.find(part), std::string::npos) << message;
  };
  expect("pictures", "a folder of 5 PNG pictures");
  expect("nifti", "name one of the 2 NIfTI files in it: a.nii, b.nii.gz");
  expect("image.zarr", "Zarr folder");
  expect("v3", "Zarr folder");
  expect("n5", "N5 folder");
  expect("outer", "image.zarr");
  expect("outer2", "such as series, tiff");
  expect("nothing", "empty");
  EXPECT_EQ(recognise(path("series")).kind, FileKind::dicom);
  EXPECT_EQ(recognise(path("series")).problem, "");
  EXPECT_EQ(recognise(write("file", at(128, "DICM"))).kind, FileKind::dicom);
  EXPECT_EQ(recognise(path("tiff")).kind, FileKind::tiff);
  EXPECT_TRUE(recognise(path("series")).folder);
}

TEST_F(Recognise, packed_files_are_what_is_in_them) {
  const std::string file = write("a.dat", at(0, "\x89PNG\r\n\x1a\n"));
  ASSERT_EQ(std::system(("gzip -k '" + file + "' && mv '" + file + ".gz' '" + path("packed") + "'").c_str()),
            0);
  EXPECT_NE(problem(path("packed")).find("PNG picture"), std::string::npos);
  // Cut off: what can be unpacked counts.
  fs::resize_file(path("packed"), fs::file_size(path("packed")) - 9);
  EXPECT_NE(problem(path("packed")).find("PNG picture"), std::string::npos);
  EXPECT_NE(problem(write("broken.gz", "\x1f\x8b nothing")).find("packed"), std::string::npos);
}

TEST(FormatTable, every_row_says_what_to_do_or_is_read) {
  for (const Format& format : formats()) {
    const bool read = format.kind != FileKind::other && format.kind != FileKind::tiff;
    EXPECT_FALSE(format.name.empty());
    EXPECT_FALSE(format.plural.empty()) << format.name;
    EXPECT_TRUE(!read || format.why.empty()) << format.name;
    EXPECT_EQ(format.why.empty(), format.instead.empty()) << format.name;
    EXPECT_TRUE(!format.endings.empty() || !format.magic[0].bytes.empty()) << format.name;
  }
}

}  // namespace
}  // namespace gvx::io
