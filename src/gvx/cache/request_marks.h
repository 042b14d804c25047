/// \file
/// RequestMarks: one word per node in which rays say what they lack there. The only thing, beside usage
/// stamps, that flows back from rendering (GPU Pro text, 3.6.4).
#pragma once

#include <cstdint>
#include <vector>

#include "gvx/core/index.h"
#include "gvx/exec/buffer.h"
#include "gvx/exec/device.h"
#include "gvx/exec/relaxed.h"

namespace gvx::cache {

/// What a ray may lack at a node; both may be asked for at once.
inline constexpr std::uint32_t kNeedsBrick = 1;
inline constexpr std::uint32_t kNeedsChildren = 2;

/// What kernels mark. A mark is kind | priority << 2.
struct RequestView {
  std::uint32_t* marks = nullptr;

  /// `gain`, 0 to 1, says how much the picture would gain: the ray's transmittance. Without atomics, so of
  /// many writers one with about the greatest gain wins; a kind that loses is asked for again in the next
  /// pass.
  GVX_HD void request(NodeIndex node, std::uint32_t kinds, float gain) const {
    const std::uint32_t mark = kinds | (1 + static_cast<std::uint32_t>(gain * 1023.0f)) << 2;
    std::uint32_t* word = marks + node.value;
    if (exec::load_relaxed(word) < mark) exec::store_relaxed(word, mark);
  }
};

struct Request {
  NodeIndex node;
  std::uint32_t kinds;
  std::uint32_t priority;
};

class RequestMarks {
 public:
  RequestMarks(const exec::Device& device, std::uint32_t nodes);

  RequestView view() { return {marks_.view().data}; }

  /// The marked nodes in order of their index; clears the marks.
  std::vector<Request> collect();

 private:
  exec::Device device_;
  exec::Buffer<std::uint32_t> marks_, indices_;
};

}  // namespace gvx::cache
