#include "gvx/open/options.h"

namespace gvx::open {

std::string FieldNaming::name(const std::string& field) const {
  const std::string flag = flag_of_ ? flag_of_(field) : "";
  return flag.empty() ? field : flag;
}

std::string FieldNaming::before_value(const std::string& field) const {
  const std::string flag = flag_of_ ? flag_of_(field) : "";
  return flag.empty() ? field + ": " : flag + " ";
}

std::string FieldNaming::advice(const char* flags, const char* fields) const {
  return flag_of_ ? flags : fields;
}

}  // namespace gvx::open
