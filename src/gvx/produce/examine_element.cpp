#include "gvx/produce/examine_element.h"

#include <cstring>
#include <exception>
#include <future>
#include <limits>
#include <memory>
#include <new>
#include <utility>

namespace gvx::produce {
namespace {

/// The one value of all voxels, if they have but one.
std::optional<ChannelRanges> single_value(VoxelType type, std::span<const std::byte> voxels) {
  const std::size_t element = voxel_bytes(type);
  // Equal to itself shifted by one voxel: all are equal.
  if (std::memcmp(voxels.data(), voxels.data() + element, voxels.size() - element) != 0) return std::nullopt;
  return with_voxel_type(type, [&](auto value) {
    std::memcpy(&value, voxels.data(), element);
    const auto v = static_cast<float>(value);
    return std::optional<ChannelRanges>(ValueRange{v, v});
  });
}

/// Of each channel the least and the greatest value; what is no data is neither.
ChannelRanges ranges_in(const TreeDescription& tree, std::span<const std::byte> voxels) {
  ChannelRanges ranges;
  const std::size_t texels = plane_texels(tree.m);
  with_voxel_type(tree.format.type, [&](auto zero) {
    const auto* plane = reinterpret_cast<const decltype(zero)*>(voxels.data());
    for (std::uint32_t c = 0; c < tree.format.channels(); ++c, plane += texels) {
      auto least = std::numeric_limits<decltype(zero)>::max(),
           greatest = std::numeric_limits<decltype(zero)>::lowest();
      for (std::size_t i = 0; i < texels; ++i) {
        least = plane[i] < least ? plane[i] : least;
        greatest = plane[i] > greatest ? plane[i] : greatest;
      }
      ranges.channel[c] = {static_cast<float>(least), static_cast<float>(greatest)};
    }
  });
  return ranges;
}

/// Keeps what comes of a batch of one element. Of a sink that nothing was handed to, the promise is broken.
class OneElement final : public ElementSink {
 public:
  explicit OneElement(std::promise<Result<Element>> promise) : promise_(std::move(promise)) {}

  void complete(std::size_t, Result<Element> made) override { promise_.set_value(std::move(made)); }
  bool cancelled(std::size_t) override { return false; }
  void drop(std::size_t) override { promise_.set_value(Error{"a producer dropped what is wanted"}); }

 private:
  std::promise<Result<Element>> promise_;
};

Result<Element> started(const Producer& producer, const NodeKey& node, ElementKind kind) {
  std::promise<Result<Element>> promise;
  std::future<Result<Element>> made = promise.get_future();
  try {
    producer.start({kind, std::span(&node, 1)}, std::make_shared<OneElement>(std::move(promise)));
    return made.get();
  } catch (const std::bad_alloc&) {
    return Error{"out of memory"};
  } catch (const std::future_error&) {
    return Error{name_of(node, kind) + ": its producer did not complete it just once"};
  } catch (const std::exception& error) {
    return Error{std::string("a producer failed: ") + error.what()};
  }
}

}  // namespace

Status check_size(const TreeDescription& tree, const NodeKey& node, ElementKind kind, const Element& made) {
  const auto expect = [&](std::size_t size, std::size_t expected, const char* what) -> Status {
    if (size == expected) return {};
    return Error{name_of(node, kind) + ": expected " + std::to_string(expected) + " " + what +
                 ", its producer made " + std::to_string(size)};
  };
  if (of_surface(kind)) return expect(made.bytes != nullptr ? 1 : 0, 1, "list of bytes");
  if (kind == ElementKind::brick) return expect(made.voxels.size(), tree.brick_bytes(), "bytes");
  const std::size_t children = std::size_t{tree.n} * tree.n * tree.n;
  GVX_TRY(expect(made.child_keys.size(), children, "keys"));
  return expect(made.children.size(), children, "descriptions");
}

void examine_element(const TreeDescription& tree, const NodeKey& node, bool in_host_memory, Element& brick) {
  const bool may_be_constant = node.level == tree.max_level && !tree.exact_ranges && tree.format.planes == 1;
  if (!may_be_constant) brick.constant.reset();
  if (!in_host_memory || tree.exact_ranges || brick.voxels.empty()) return;
  if (tree.format.content == VoxelContent::scalar) brick.found = ranges_in(tree, brick.voxels);
  if (!may_be_constant || brick.constant) return;
  const std::size_t plane = plane_texels(tree.m) * voxel_bytes(tree.format.type);
  brick.constant = single_value(tree.format.type, brick.voxels.first(plane));
}

Result<Element> make_element(const Producer& producer, const NodeKey& node, ElementKind kind) {
  const TreeDescription& tree = producer.description();
  GVX_ASSIGN(Element made, started(producer, node, kind));
  GVX_TRY(check_size(tree, node, kind, made));
  examine_element(tree, node, makes_host_memory(producer), made);
  return made;
}

}  // namespace gvx::produce
