#include "gvx/open/closest_word.h"

#include <vector>

#include <gtest/gtest.h>

namespace gvx::open {
namespace {

TEST(ClosestWord, is_the_one_that_few_letters_differ_from) {
  const std::vector<std::string> names = {"sponge", "stored-sponge", "cloud", "terrain"};
  EXPECT_EQ(closest_word("spong", names), "sponge");
  EXPECT_EQ(closest_word("colud", names), "cloud");
  EXPECT_EQ(closest_word("stored", names), "stored-sponge");
  EXPECT_FALSE(closest_word("head", names));
  EXPECT_FALSE(closest_word("xy", names));
}

}  // namespace
}  // namespace gvx::open
