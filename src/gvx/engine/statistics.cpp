#include "gvx/engine/statistics.h"

#include <sys/resource.h>

namespace gvx::engine {

std::uint64_t peak_memory_bytes() {
  struct rusage usage {};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<std::uint64_t>(usage.ru_maxrss) * 1024;
}

}  // namespace gvx::engine
