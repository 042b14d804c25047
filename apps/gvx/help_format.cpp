#include "help_format.h"

#include <algorithm>
#include <set>
#include <string_view>

namespace gvx::app {
namespace {

std::string replaced(std::string text, std::string_view what, std::string_view with) {
  for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + with.size())) {
    text.replace(at, what.size(), with);
  }
  return text;
}

/// What a flag takes, from CLI11's "TEXT", "TEXT:{cpu,cuda}", "INT:INT in [1 - 4]" or "INT:NONNEGATIVE".
std::string value_text(const CLI::Option& option) {
  const std::string type = option.get_type_name();
  const std::size_t colon = type.find(':');
  const std::string kind = type.substr(0, colon),
                    check = colon == std::string::npos ? "" : type.substr(colon + 1);
  if (check.starts_with('{') && check.ends_with('}')) {
    return replaced(check.substr(1, check.size() - 2), ",", "|");
  }
  const std::string name = kind == "INT" || kind == "UINT" ? "N" : kind == "FLOAT" ? "NUMBER" : kind;
  const std::size_t open = check.find('['), close = check.find(']');
  if (open != std::string::npos && close != std::string::npos) {
    return name + " (" + replaced(check.substr(open + 1, close - open - 1), " - ", " to ") + ")";
  }
  return check == "NONNEGATIVE" ? name + " (0 or more)" : name;
}

/// " (not with --exact, --frames)".
std::string with_flags(const char* how, const std::set<CLI::Option*>& options) {
  std::set<std::string> names;
  for (const CLI::Option* option : options) names.insert(option->get_name());
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
  return text.empty() ? "" : std::string(" (") + how + " " + text + ")";
}

}  // namespace

std::string HelpFormat::make_option_name(const CLI::Option* option, bool is_positional) const {
  std::string name = CLI::Formatter::make_option_name(option, is_positional);
  if (is_positional) {
    std::transform(name.begin(), name.end(), name.begin(),
                   [](char c) { return c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c; });
    return name;
  }
  return replaced(replaced(name, "{false}", ""), ",", ", ");
}

std::string HelpFormat::make_option_opts(const CLI::Option* option) const {
  std::string text;
  if (!option->get_option_text().empty()) {
    text = " " + option->get_option_text();
  } else if (option->get_type_size() != 0 && !option->get_positional()) {
    const std::string value = value_text(*option);
    if (!value.empty()) text = " " + value;
    if (!option->get_default_str().empty()) text += " (default: " + option->get_default_str() + ")";
    if (option->get_required()) text += " (required)";
  }
  return text + with_flags("only with", option->get_needs()) + with_flags("not with", option->get_excludes());
}

std::string HelpFormat::make_option_usage(const CLI::Option* option) const {
  return make_option_name(option, true) + (option->get_expected_max() > 1 ? ".." : "");
}

}  // namespace gvx::app
