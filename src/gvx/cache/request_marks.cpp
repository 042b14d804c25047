#include "gvx/cache/request_marks.h"

#include "gvx/exec/algorithms.h"

namespace gvx::cache {

RequestMarks::RequestMarks(const exec::Device& device, std::uint32_t nodes)
    : device_(device), marks_(device, nodes), indices_(device, nodes) {}

std::vector<Request> RequestMarks::collect() {
  const auto marks = marks_.view();
  const std::size_t count = exec::find_nonzero(device_, marks, indices_.view());
  device_.synchronize();
  std::vector<Request> requests;
  requests.reserve(count);
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint32_t node = indices_.view()[i];
    requests.push_back({NodeIndex(node), marks[node] & 3u, marks[node] >> 2});
    marks[node] = 0;
  }
  return requests;
}

}  // namespace gvx::cache
