/// \file
/// The checksum of everything in a store: XXH3, 64 bits; a field of 32 bits holds its low half.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

namespace gvx::store {

/// XXH3 of the bytes.
std::uint64_t checksum(std::span<const std::byte> bytes);

/// The same of bytes that come piece by piece.
class RunningChecksum {
 public:
  RunningChecksum();
  ~RunningChecksum();
  void add(std::span<const std::byte> bytes);
  std::uint64_t value() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace gvx::store
