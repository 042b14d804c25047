#include "gvx/store/notes.h"

#include <string>

#include <gtest/gtest.h>

#include "gvx/store/store_reader.h"
#include "gvx/store/store_test_support.h"
#include "gvx/store/verify.h"

namespace gvx::store {
namespace {

/// A store of two channels with what `add` adds.
template <typename Add>
std::string store_with(const std::string& name, Add add) {
  const std::string path = testing::TempDir() + "gvx_notes_" + name + ".gvx";
  VolumeInfo info;
  info.shape = TreeShape::covering({20, 20, 20}, 2, 16);
  info.format = {VoxelType::u8, VoxelContent::scalar, 2};
  for (std::size_t c = 0; c < 2; ++c) {
    info.ranges.channel[c] = {7, 7};
    info.histograms.emplace_back(kHistogramBins);
  }
  const auto writer = StoreWriter::create(path, info.shape, info.format).value();
  for (std::uint32_t l = 0; l < info.shape.levels; ++l) {
    EXPECT_TRUE(writer->set_background(l, info.ranges).ok());
  }
  EXPECT_TRUE(add(*writer).ok());
  EXPECT_TRUE(writer->finish(info).ok());
  return path;
}

TEST(Notes, AreReadAsTheyWereWritten) {
  const VolumeNotes notes{"\xC2\xB5m", {{"DAPI", Vec3f{0, 0, 1}}, {"", std::nullopt}}};
  const std::string path = store_with("good", [&](StoreWriter& w) { return write_notes(w, notes); });
  const auto reader = StoreReader::open(path).value();
  const VolumeNotes read = read_notes(*reader).value();
  EXPECT_EQ(read.unit, notes.unit);
  ASSERT_EQ(read.channels.size(), 2u);
  EXPECT_EQ(read.channels[0].name, "DAPI");
  EXPECT_EQ(read.channels[0].color, Vec3f(0, 0, 1));
  EXPECT_EQ(read.channels[1].name, "");
  EXPECT_FALSE(read.channels[1].color.has_value());
  EXPECT_TRUE(verify(exec::Device::cpu(), path, {}).ok());
}

TEST(Notes, NoneTakeNoSection) {
  const std::string path = store_with("none", [](StoreWriter& w) { return write_notes(w, {}); });
  const auto reader = StoreReader::open(path).value();
  EXPECT_EQ(reader->sections().size(), 3u);
  EXPECT_TRUE(read_notes(*reader).value().empty());
}

TEST(Notes, ThatAreBrokenAreErrors) {
  for (const std::string text :
       {"", "[]", "{\"unit\": 3}", "{\"channels\": [{}]}", "{\"channels\": [1, 2]}",
        "{\"channels\": [{\"color\": [0, 0, 2]}, {}]}", "{\"channels\": [{\"name\": 1}, {}]}"}) {
    const std::string path = store_with("broken", [&](StoreWriter& w) {
      return w.add_section(kNotesSection, 1, false, std::as_bytes(std::span(text)));
    });
    const auto notes = read_notes(*StoreReader::open(path).value());
    ASSERT_FALSE(notes.ok()) << text;
    EXPECT_NE(notes.error().message.find("the notes are not the JSON that gvx writes"), std::string::npos);
  }
  // Of a version to come: ignored.
  const std::string path =
      store_with("newer", [&](StoreWriter& w) { return w.add_section(kNotesSection, 2, false, {}); });
  EXPECT_TRUE(read_notes(*StoreReader::open(path).value()).value().empty());
}

}  // namespace
}  // namespace gvx::store
