#include "gvx/exec/host_memory.h"

#include <algorithm>
#include <cstdint>
#include <new>

#include <gtest/gtest.h>

namespace gvx::exec {
namespace {

TEST(HostMemory, is_aligned_and_zeroed_and_can_be_written) {
  for (const std::size_t bytes : {std::size_t{1}, std::size_t{63}, std::size_t{1} << 20,
                                  (std::size_t{2} << 20) + 1, std::size_t{9} << 20}) {
    const HostMemory memory(bytes);
    auto* begin = static_cast<std::uint8_t*>(memory.data());
    EXPECT_EQ(reinterpret_cast<std::uintptr_t>(begin) % HostMemory::kAlignment, 0u) << bytes;
    EXPECT_TRUE(std::all_of(begin, begin + bytes, [](std::uint8_t byte) { return byte == 0; })) << bytes;
    std::fill_n(begin, bytes, std::uint8_t{7});
    EXPECT_EQ(begin[bytes - 1], 7) << bytes;
  }
}

TEST(HostMemory, moves) {
  HostMemory first(100);
  auto* number = static_cast<int*>(first.data());
  *number = 42;
  HostMemory second(std::move(first));
  EXPECT_EQ(second.data(), number);
  HostMemory third(8);
  third = std::move(second);
  EXPECT_EQ(*static_cast<int*>(third.data()), 42);
  EXPECT_EQ(HostMemory(0).data(), nullptr);
}

TEST(HostMemory, of_absurd_sizes_is_not_there) {
  EXPECT_THROW(HostMemory(SIZE_MAX), std::bad_alloc);
}

}  // namespace
}  // namespace gvx::exec
