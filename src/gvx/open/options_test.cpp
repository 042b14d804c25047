#include "gvx/open/options.h"

#include <gtest/gtest.h>

namespace gvx::open {
namespace {

TEST(FieldNaming, fields_have_their_own_names_unless_a_flag_said_them) {
  const FieldNaming fields;
  EXPECT_EQ(fields.name("labels"), "labels");
  EXPECT_EQ(fields.before_value("functions[0]"), "functions[0]: ");
  EXPECT_EQ(fields.advice("--window", "window"), "window");
  const FieldNaming flags([](const std::string& field) { return field == "labels" ? "--labels" : ""; });
  EXPECT_EQ(flags.name("labels"), "--labels");
  EXPECT_EQ(flags.before_value("labels"), "--labels ");
  EXPECT_EQ(flags.before_value("functions[0]"), "functions[0]: ");
  EXPECT_EQ(flags.advice("--window", "window"), "--window");
}

}  // namespace
}  // namespace gvx::open
