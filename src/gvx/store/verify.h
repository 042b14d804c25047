/// \file
/// verify: reads every byte of a store that means something, and checks it.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "gvx/core/result.h"
#include "gvx/exec/device.h"

namespace gvx::store {

/// What was found sound.
struct VerifyReport {
  std::uint64_t nodes = 0;
  std::uint64_t bricks = 0;
  std::uint64_t constant_nodes = 0;
  std::uint64_t bytes_read = 0;
};

/// Checks header, sections, every page of the index, and of every brick its checksum, its size and that its
/// voxels lie in its node's range, which lies in its parent's. Of sections and payloads that this program
/// does not know it checks the checksums. Many nodes that have one record are checked at once. The first
/// error names the part. `progress` (may be empty) is called with done and all nodes from one thread at a
/// time.
Result<VerifyReport> verify(const exec::Device& cpu, const std::string& path,
                            const std::function<void(std::uint64_t, std::uint64_t)>& progress);

}  // namespace gvx::store
