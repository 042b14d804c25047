// Stores that are cut, damaged or made up: an error that names the file, never a crash, never a wrong voxel
// in silence.

#include <array>
#include <fstream>
#include <random>

#include <gtest/gtest.h>

#include "gvx/store/codec.h"
#include "gvx/store/store_reader.h"
#include "gvx/store/store_test_support.h"
#include "gvx/store/verify.h"

namespace gvx::store {
namespace {

class HostileStore : public testing::Test {
 protected:
  void SetUp() override {
    const TestVolume<std::uint8_t> volume({40, 30, 20}, [](auto x, auto y, auto z) { return x * y + z * 3; });
    ASSERT_TRUE(write_store(volume, path_, 2, 8).ok());
    std::ifstream file(path_, std::ios::binary);
    good_.assign(std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>());
  }

  /// Verifies a store of these bytes.
  Result<VerifyReport> verify_bytes(const std::string& bytes) {
    std::ofstream(path_, std::ios::binary | std::ios::trunc)
        .write(bytes.data(), std::streamsize(bytes.size()));
    return verify(exec::Device::cpu(1), path_, {});
  }

  std::string path_ = testing::TempDir() + "gvx_hostile.gvx";
  std::string good_;
};

/// A store of which some parts are made up, with checksums that match.
class Forged {
 public:
  explicit Forged(std::string good) : bytes_(std::move(good)) {
    std::memcpy(&header, bytes_.data(), sizeof(header));
    table.resize(header.sections);
    std::memcpy(table.data(), bytes_.data() + header.table_offset, table.size() * sizeof(SectionEntry));
  }

  BlockRef append(std::span<const std::byte> bytes) {
    const BlockRef block{bytes_.size(), static_cast<std::uint32_t>(bytes.size()),
                         static_cast<std::uint32_t>(checksum(bytes))};
    bytes_.append(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    return block;
  }

  /// A page of references, all to one page.
  PageRef append_page_of(const PageRef& ref) {
    std::array<PageRef, kPageNodes> page;
    page.fill(ref);
    std::vector<std::byte> compressed;
    compress(Codec::zstd, {sizeof(PageRef), kPageNodes}, std::as_bytes(std::span(page)), compressed);
    return {append(compressed)};
  }

  SectionEntry& section(const std::string& name) {
    return *std::find_if(table.begin(), table.end(),
                         [&](const SectionEntry& entry) { return name_of(entry.name) == name; });
  }
  template <typename T>
  std::vector<T> read(const std::string& name) {
    std::vector<T> read(section(name).bytes / sizeof(T));
    std::memcpy(read.data(), bytes_.data() + section(name).offset, read.size() * sizeof(T));
    return read;
  }
  template <typename T>
  void replace(const std::string& name, const std::vector<T>& with) {
    const auto bytes = std::as_bytes(std::span(with));
    section(name).checksum = checksum(bytes);
    section(name).bytes = bytes.size();
    section(name).offset = append(bytes).offset;
  }

  /// The file, with the header and the table as they are now.
  std::string bytes() {
    std::string all = bytes_;
    const auto entries = std::as_bytes(std::span(table));
    header.table_offset = all.size();
    header.table_checksum = checksum(entries);
    all.append(reinterpret_cast<const char*>(entries.data()), entries.size());
    header.file_bytes = all.size();
    const auto span = std::as_bytes(std::span(&header, 1));
    header.header_checksum = checksum(span.first(offsetof(FileHeader, header_checksum)));
    std::memcpy(all.data(), &header, sizeof(header));
    return all;
  }

  FileHeader header;
  std::vector<SectionEntry> table;

 private:
  std::string bytes_;
};

TEST_F(HostileStore, every_truncation_is_an_error_that_names_the_file) {
  for (std::size_t length = 0; length < good_.size(); length += length < 600 ? 1 : 97) {
    const auto report = verify_bytes(good_.substr(0, length));
    ASSERT_FALSE(report.ok()) << length;
    ASSERT_NE(report.error().message.find(path_), std::string::npos);
    ASSERT_EQ(report.error().message.find('\n'), std::string::npos);
  }
}

TEST_F(HostileStore, every_flipped_byte_is_found) {
  ASSERT_TRUE(verify_bytes(good_).ok());
  for (std::size_t i = 0; i < good_.size(); i += i < 256 ? 1 : 61) {
    std::string bad = good_;
    bad[i] = static_cast<char>(bad[i] ^ 0x10);
    ASSERT_FALSE(verify_bytes(bad).ok()) << "byte " << i;
  }
}

TEST_F(HostileStore, every_single_byte_of_a_small_store_matters) {
  for (const std::uint32_t border : {1u, 2u}) {
    const TestVolume<std::uint16_t> volume({66, 5, 3}, [](auto x, auto, auto) { return x / 16; });
    ASSERT_TRUE(write_store(volume, path_, 2, 8, Codec::zstd, 1, border).ok());
    std::ifstream file(path_, std::ios::binary);
    const std::string good{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
    ASSERT_TRUE(verify_bytes(good).ok());
    for (std::size_t i = 0; i < good.size(); i += border == 1 ? 1 : 7) {
      std::string bad = good;
      bad[i] = static_cast<char>(bad[i] ^ (1 << i % 8));
      const auto flipped = verify_bytes(bad);
      ASSERT_FALSE(flipped.ok()) << "byte " << i;
      ASSERT_EQ(flipped.error().message.find(path_), 0u) << flipped.error().message;
      ASSERT_EQ(flipped.error().message.find('\n'), std::string::npos);
      if (i % 8 != 0) continue;
      ASSERT_FALSE(verify_bytes(good.substr(0, i)).ok()) << i << " bytes";
    }
  }
}

TEST_F(HostileStore, a_made_up_header_with_a_right_checksum_does_no_harm) {
  std::mt19937 random(11);
  int opened = 0;
  for (int i = 0; i < 3000; ++i) {
    std::string bad = good_;
    FileHeader header;
    std::memcpy(&header, bad.data(), sizeof(header));
    auto* bytes = reinterpret_cast<unsigned char*>(&header);
    for (int k = 0; k < 1 + i % 3; ++k)
      bytes[12 + random() % (sizeof(header) - 20)] = static_cast<unsigned char>(random());
    const auto span = std::as_bytes(std::span(&header, 1));
    header.header_checksum = checksum(span.first(offsetof(FileHeader, header_checksum)));
    std::memcpy(bad.data(), &header, sizeof(header));
    opened += verify_bytes(bad).ok() ? 1 : 0;
  }
  // Most fields matter; those that only place and scale the volume leave its voxels sound.
  EXPECT_LT(opened, 2500);
}

TEST_F(HostileStore, a_placement_that_no_ray_can_cross_is_an_error) {
  for (const double scale : {0.0, 1e-200, 1e150, 1e308, -1e-9}) {
    std::string bad = good_;
    FileHeader header;
    std::memcpy(&header, bad.data(), sizeof(header));
    header.voxel_to_world[0] = scale;
    const auto span = std::as_bytes(std::span(&header, 1));
    header.header_checksum = checksum(span.first(offsetof(FileHeader, header_checksum)));
    std::memcpy(bad.data(), &header, sizeof(header));
    EXPECT_FALSE(verify_bytes(bad).ok()) << scale;
  }
}

TEST_F(HostileStore, dimensions_whose_pages_overflow_are_an_error) {
  Forged forged(good_);
  FileHeader& header = forged.header;
  for (std::uint64_t& d : header.dimensions) d = 0x7fffffff;
  header.levels = TreeShape::covering({0x7fffffff, 0x7fffffff, 0x7fffffff}, header.n, header.m).levels;
  const auto report = verify_bytes(forged.bytes());
  ASSERT_FALSE(report.ok());
  EXPECT_NE(report.error().message.find("section \"directory\""), std::string::npos)
      << report.error().message;
}

TEST_F(HostileStore, a_made_up_table_of_sections_does_no_harm) {
  std::mt19937 random(5);
  int opened = 0;
  for (int i = 0; i < 1000; ++i) {
    Forged forged(good_);
    auto* bytes = reinterpret_cast<unsigned char*>(forged.table.data());
    for (int k = 0; k < 1 + i % 3; ++k) {
      bytes[random() % (forged.table.size() * sizeof(SectionEntry))] = static_cast<unsigned char>(random());
    }
    const auto report = verify_bytes(forged.bytes());
    opened += report.ok() ? 1 : 0;
    if (report.ok()) continue;
    ASSERT_EQ(report.error().message.find(path_), 0u) << report.error().message;
  }
  // Of an entry 8 bytes are reserved, and of its flags all but one bit.
  EXPECT_LT(opened, 500);
}

TEST_F(HostileStore, wrong_tables_of_sections_are_errors_that_name_the_section) {
  const auto message = [&](const std::function<void(Forged&)>& change) {
    Forged forged(good_);
    change(forged);
    const auto report = verify_bytes(forged.bytes());
    return report.ok() ? std::string() : report.error().message;
  };
  EXPECT_NE(message([](Forged& f) { f.section("records").name = stored_name("other"); }).find("\"other\""),
            std::string::npos);
  EXPECT_NE(message([](Forged& f) {
              f.section("records").flags = 0;
              f.section("records").name = stored_name("other");
            }).find("section \"records\" is missing"),
            std::string::npos);
  EXPECT_NE(message([](Forged& f) { f.section("metadata").version = 2; }).find("section \"metadata\""),
            std::string::npos);
  EXPECT_NE(message([](Forged& f) { f.section("metadata").offset = 1ull << 63; }).find("\"metadata\" is not"),
            std::string::npos);
  EXPECT_NE(message([](Forged& f) { f.section("metadata").bytes = ~0ull; }).find("\"metadata\" is not"),
            std::string::npos);
  EXPECT_NE(message([](Forged& f) { f.section("metadata").offset = 100; }).find("\"metadata\" is not"),
            std::string::npos);
  EXPECT_NE(message([](Forged& f) { f.section("metadata").offset -= 1; }).find("share bytes"),
            std::string::npos);
  EXPECT_NE(message([](Forged& f) {
              f.table.push_back(f.table[0]);
              f.header.sections = 4;
            }).find("two sections \"directory\""),
            std::string::npos);
  EXPECT_NE(message([](Forged& f) { f.header.sections = 0xffffffff; }).find("sections; at most"),
            std::string::npos);
  EXPECT_NE(message([](Forged& f) { f.header.record_bytes = 0xffffffff; }).find("4294967295 bytes"),
            std::string::npos);
  EXPECT_NE(message([](Forged& f) { f.header.flags = 6; }).find("newer gvx"), std::string::npos);
  EXPECT_NE(message([](Forged& f) { f.header.border = 3; }).find("border"), std::string::npos);
}

TEST_F(HostileStore, made_up_fields_of_records_do_no_harm) {
  std::mt19937 random(6);
  for (int i = 0; i < 1000; ++i) {
    Forged forged(good_);
    auto fields = forged.read<unsigned char>("records");
    for (int k = 0; k < 1 + i % 3; ++k)
      fields[random() % fields.size()] = static_cast<unsigned char>(random());
    forged.replace("records", fields);
    if (i % 2 == 0) forged.header.record_bytes = 20 + static_cast<std::uint32_t>(random() % 30);
    const auto report = verify_bytes(forged.bytes());
    if (report.ok()) continue;
    ASSERT_EQ(report.error().message.find(path_), 0u) << report.error().message;
  }
}

TEST_F(HostileStore, made_up_pages_do_no_harm) {
  const TestVolume<std::uint8_t> volume({9600, 3, 2}, [](auto x, auto, auto) { return x / 100; });
  ASSERT_TRUE(write_store(volume, path_, 2, 8).ok());
  std::ifstream file(path_, std::ios::binary);
  const std::string good{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  std::mt19937 random(7);
  const auto refs = Forged(good).read<PageRef>("directory");
  for (int i = 0; i < 300; ++i) {
    Forged forged(good);
    auto directory = refs;
    PageRef& ref = directory[random() % directory.size()];
    switch (i % 4) {
      case 0:  // a page of another level, and perhaps of another height
        ref = refs[random() % refs.size()];
        break;
      case 1: {  // a page of pages, too high or too low
        ref = forged.append_page_of(refs[random() % refs.size()]);
        break;
      }
      case 2: {  // any bytes, as one record
        const std::vector<std::uint32_t> record(6, static_cast<std::uint32_t>(random()));
        ref = {forged.append(std::as_bytes(std::span(record)))};
        ref.bytes |= PageRef::kOneRecord;
        break;
      }
      default:
        reinterpret_cast<unsigned char*>(&ref)[random() % sizeof(ref)] = static_cast<unsigned char>(random());
    }
    if (ref == refs[static_cast<std::size_t>(&ref - directory.data())]) continue;
    forged.replace("directory", directory);
    const auto report = verify_bytes(forged.bytes());
    // Where small levels are alike, one may stand for another.
    if (i % 4 == 0 && report.ok()) continue;
    ASSERT_FALSE(report.ok()) << i;
    ASSERT_EQ(report.error().message.find(path_), 0u) << report.error().message;
  }
}

TEST_F(HostileStore, pages_that_share_pages_are_no_tree_without_an_end) {
  Forged forged(good_);
  FileHeader& header = forged.header;
  for (std::uint64_t& d : header.dimensions) d = 0x7fffffff;
  const TreeShape shape = TreeShape::covering({0x7fffffff, 0x7fffffff, 0x7fffffff}, header.n, header.m);
  header.levels = shape.levels;
  // Each page names one page 512 times, down to records of constant nodes that differ.
  std::vector<std::byte> records(std::size_t{kPageNodes} * header.record_bytes), compressed;
  const RecordLayout layout(VoxelFormat{});
  for (std::size_t i = 0; i < kPageNodes; ++i) {
    const auto value = static_cast<float>(i % 2);
    layout.encode({0, 0, 0, ValueRange{value, value}}, records.data() + i * layout.bytes());
  }
  compress(Codec::zstd, {layout.bytes(), kPageNodes}, records, compressed);
  std::vector<PageRef> pages = {{forged.append(compressed)}};
  while (pages.size() <= shape.index_height(shape.levels - 1))
    pages.push_back(forged.append_page_of(pages.back()));
  std::vector<PageRef> directory;
  for (std::uint32_t l = 0; l < shape.levels; ++l) directory.push_back(pages[shape.index_height(l)]);
  // The root's range holds all values.
  forged.replace("directory", directory);
  const auto report = verify_bytes(forged.bytes());
  ASSERT_FALSE(report.ok());
  EXPECT_NE(report.error().message.find("corrupt"), std::string::npos) << report.error().message;
  // Rays would find what it says all the same.
  EXPECT_TRUE(StoreReader::open(path_).value()->node({shape.levels - 1, 1ull << 27, 5, 77}).ok());
}

TEST_F(HostileStore, what_is_no_store_is_an_error) {
  EXPECT_FALSE(StoreReader::open("/no/such/file.gvx").ok());
  EXPECT_FALSE(StoreReader::open(testing::TempDir()).ok());
  EXPECT_FALSE(verify_bytes("").ok());
  EXPECT_FALSE(verify_bytes(std::string(5000, 'x')).ok());
  std::string version = good_;
  version[8] = 9;
  EXPECT_EQ(verify_bytes(version).error().message,
            path_ + ": made by a newer gvx: version 9; this program reads up to 3");
  version[8] = 1;
  EXPECT_NE(verify_bytes(version).error().message.find(".gvx version 1; this program reads versions 2 to 3"),
            std::string::npos);
}

}  // namespace
}  // namespace gvx::store
