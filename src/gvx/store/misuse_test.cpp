// What a caller does wrong is an error that says what to do instead.

#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "gvx/store/shape_check.h"
#include "gvx/store/store_reader.h"
#include "gvx/store/store_test_support.h"
#include "gvx/store/verify.h"

namespace gvx::store {
namespace {

std::string message(const Status& status) {
  return status.ok() ? "" : status.error().message;
}

void expect_error(const Status& status, const std::string& what) {
  EXPECT_NE(message(status).find(what), std::string::npos) << '"' << message(status) << "\" lacks " << what;
}

TEST(TreeShape, that_no_store_has_is_an_error) {
  const TreeShape good = TreeShape::covering({100, 20, 3}, 2, 16);
  EXPECT_TRUE(check_shape(good).ok());
  const auto expect = [&](auto change, const char* what) {
    TreeShape shape = good;
    change(shape);
    expect_error(check_shape(shape), what);
    const std::string path = testing::TempDir() + "gvx_misuse_shape.gvx";
    EXPECT_FALSE(StoreWriter::create(path, shape, VoxelFormat()).ok());
  };
  expect([](auto& s) { s.n = 1; }, "expected 2 or 3");
  expect([](auto& s) { s.m = 15; }, "expected 8, 16 or 32");
  expect([](auto& s) { s.dimensions.y = 0; }, "100 x 0 x 3 voxels");
  expect([](auto& s) { s.levels = 3; }, "3 levels; expected 4");
}

/// A writer of 20^3 voxels in bricks of 16^3: a root, and a level of one page.
class MisusedWriter : public testing::Test {
 protected:
  VolumeInfo info() const {
    VolumeInfo info;
    info.shape = shape_;
    info.ranges = ValueRange{7, 7};
    info.histograms = {std::vector<std::uint64_t>(kHistogramBins)};
    return info;
  }
  void set_backgrounds() {
    for (std::uint32_t level = 0; level < shape_.levels; ++level)
      ASSERT_TRUE(writer_->set_background(level, ValueRange{7, 7}).ok());
  }

  TreeShape shape_ = TreeShape::covering({20, 20, 20}, 2, 16);
  std::unique_ptr<StoreWriter> writer_ =
      StoreWriter::create(testing::TempDir() + "gvx_misuse.gvx", shape_, VoxelFormat()).value();
  std::vector<std::byte> page_ = std::vector<std::byte>(kPageNodes * RecordLayout(VoxelFormat()).bytes());
};

TEST_F(MisusedWriter, refuses_pages_that_the_tree_lacks_and_pages_of_another_size) {
  expect_error(writer_->add_page(2, {}, page_), "level 2: the tree has 2 levels");
  expect_error(writer_->add_page(1, {0, 1, 0}, page_), "there is no page 0, 1, 0 in 1 x 1 x 1");
  expect_error(writer_->add_page(1, {0, 0, -1}, page_), "there is no page");
  expect_error(writer_->add_page(1, {}, std::span(page_).first(24)), "a page of 24 bytes");
  expect_error(writer_->add_page_layer(2, 0, {}), "the tree has 2 levels");
  expect_error(writer_->add_page_layer(1, 0, {}), "a layer of 0 records; expected 512");
}

TEST_F(MisusedWriter, refuses_backgrounds_that_are_not_constant_or_late) {
  expect_error(writer_->set_background(5, ValueRange{7, 7}), "the tree has 2 levels");
  ASSERT_TRUE(writer_->add_page(1, {}, page_).ok());
  expect_error(writer_->set_background(1, ValueRange{7, 7}), "before the first page");
}

TEST_F(MisusedWriter, refuses_sections_without_a_name_or_twice) {
  const std::byte bytes[3] = {};
  ASSERT_TRUE(writer_->add_section("notes", 1, false, bytes).ok());
  expect_error(writer_->add_section("notes", 1, false, bytes), "there already");
  expect_error(writer_->add_section("", 1, false, bytes), "1 to 24");
  expect_error(writer_->add_section("two words", 1, false, bytes), "without a space");
  expect_error(writer_->add_section(std::string(25, 'x'), 1, false, bytes), "1 to 24");
}

TEST_F(MisusedWriter, finishes_only_what_is_complete_and_as_it_was_begun) {
  set_backgrounds();
  VolumeInfo other = info();
  other.shape.m = 8;
  expect_error(writer_->finish(other), "another shape");
  other = info();
  other.format.planes = 2;
  expect_error(writer_->finish(other), "another format");
  other = info();
  other.histograms.clear();
  expect_error(writer_->finish(other), "histogram");
  ASSERT_TRUE(writer_->finish(info()).ok());
}

TEST_F(MisusedWriter, finishes_no_index_with_gaps) {
  ASSERT_TRUE(writer_->set_background(0, ValueRange{7, 7}).ok());
  expect_error(writer_->finish(info()), "level 1: a page is missing");
}

TEST_F(MisusedWriter, adds_nothing_to_a_complete_store) {
  set_backgrounds();
  ASSERT_TRUE(writer_->finish(info()).ok());
  const std::byte bytes[3] = {};
  expect_error(writer_->add_section("late", 1, false, bytes), "complete");
  EXPECT_FALSE(writer_->add_block(bytes).ok());
  EXPECT_FALSE(writer_->finish(info()).ok());
  EXPECT_TRUE(verify(exec::Device::cpu(), testing::TempDir() + "gvx_misuse.gvx", {}).ok());
}

TEST(IndexOfManyPages, layers_that_come_too_late_and_gaps_are_errors) {
  // 9 x 1 x 10 pages of one level: two blocks of layers.
  const TreeShape shape = TreeShape::covering({8 * 8 * 9, 8, 8 * 8 * 10}, 2, 8);
  const std::uint32_t finest = shape.levels - 1;
  const std::vector<std::byte> page(kPageNodes * RecordLayout(VoxelFormat()).bytes());
  const auto writer =
      StoreWriter::create(testing::TempDir() + "gvx_misuse_order.gvx", shape, VoxelFormat()).value();
  expect_error(writer->add_page(finest, {0, 0, 9}, page), "a page is missing");
  const auto other =
      StoreWriter::create(testing::TempDir() + "gvx_misuse_order2.gvx", shape, VoxelFormat()).value();
  ASSERT_TRUE(other->set_background(finest, ValueRange{7, 7}).ok());
  ASSERT_TRUE(other->add_page(finest, {0, 0, 9}, page).ok());
  expect_error(other->add_page(finest, {0, 0, 2}, page), "too late");
}

TEST(MisusedReader, nodes_and_memory_that_do_not_fit_are_errors) {
  const TestVolume<std::uint8_t> volume({20, 20, 20}, [](auto x, auto y, auto z) { return x + y + z; });
  const std::string path = testing::TempDir() + "gvx_misuse_read.gvx";
  ASSERT_TRUE(write_store(volume, path, 2, 16).ok());
  const auto reader = StoreReader::open(path).value();
  EXPECT_NE(reader->node({9, 0, 0, 0}).error().message.find("not in the tree"), std::string::npos);
  EXPECT_NE(reader->node({1, 2, 0, 0}).error().message.find("not in the tree"), std::string::npos);
  const NodeRecord record = reader->node({1, 0, 0, 0}).value();
  std::vector<std::byte> brick(reader->info().brick_bytes());
  EXPECT_TRUE(reader->read_brick({1, 0, 0, 0}, record, brick).ok());
  const std::span<std::byte> less = std::span(brick).first(brick.size() - 1);
  expect_error(reader->read_brick({1, 0, 0, 0}, record, less), "expected info().brick_bytes(2)");
  expect_error(reader->read_brick({1, 0, 0, 0}, record, brick, 0), "expected 1 or 2");
  expect_error(reader->read_brick({1, 0, 0, 0}, record, brick, 3), "expected 1 or 2");
}

}  // namespace
}  // namespace gvx::store
