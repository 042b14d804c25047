#include "command_line.h"

#include <algorithm>
#include <string_view>
#include <vector>

#include "gvx/open/closest_word.h"

namespace gvx::app {
namespace {

std::string upper_case(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](char c) { return c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c; });
  return text;
}

std::string joined(const std::vector<std::string>& words, const std::string& last_separator) {
  std::string text;
  for (std::size_t i = 0; i < words.size(); ++i) {
    text += (i == 0 ? "" : i + 1 == words.size() ? last_separator : ", ") + words[i];
  }
  return text;
}

std::string suggestion(const std::string& word, const std::vector<std::string>& names) {
  const auto near = open::closest_word(word, names);
  return near ? "; did you mean " + *near + "?" : "";
}

std::vector<std::string> command_names(const CLI::App& program) {
  std::vector<std::string> names;
  for (const CLI::App* command : program.get_subcommands({})) names.push_back(command->get_name());
  return names;
}

/// The names of a flag as they are typed.
std::vector<std::string> flag_names(const CLI::Option& option) {
  std::vector<std::string> names;
  for (const std::string& name : option.get_snames()) names.push_back("-" + name);
  for (const std::string& name : option.get_lnames()) names.push_back("--" + name);
  return names;
}

const CLI::Option* find_flag(const CLI::App& command, const std::string& name) {
  for (const CLI::Option* option : command.get_options()) {
    const std::vector<std::string> names = flag_names(*option);
    if (std::find(names.begin(), names.end(), name) != names.end()) return option;
  }
  return nullptr;
}

bool is_flag(std::string_view word) {
  const auto letter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); };
  return word.size() > 1 && word[0] == '-' && (letter(word[1]) || (word[1] == '-' && word.size() > 2));
}

std::string help_of(const CLI::App& command) {
  return command.get_parent() == nullptr ? " (gvx --help)" : " (gvx " + command.get_name() + " --help)";
}

/// What a flag or an argument is called in sentences.
std::string name_of(const CLI::Option& option) {
  const std::vector<std::string> names = flag_names(option);
  if (names.empty()) return upper_case(option.get_name(true));
  return names.front().size() == 2 && option.get_required() ? names.front() : names.back();
}

/// "gvx render SCENE -o OUTPUT": the least that must be typed.
std::string usage(const CLI::App& command) {
  std::string text = "gvx " + command.get_name();
  for (const CLI::Option* option : command.get_options()) {
    if (!option->get_required()) continue;
    text += " " + name_of(*option);
    if (!flag_names(*option).empty()) text += " " + upper_case(option->get_lnames().front());
  }
  return text;
}

std::optional<std::string> unknown_flag(const CLI::App& command, const std::string& word) {
  const std::string name = word.substr(0, word.find('='));
  if (find_flag(command, name) != nullptr) return std::nullopt;
  // -oNAME is -o NAME.
  if (name[1] != '-' && find_flag(command, name.substr(0, 2)) != nullptr) return std::nullopt;
  std::vector<std::string> names;
  for (const CLI::Option* option : command.get_options()) {
    for (const std::string& known : flag_names(*option)) {
      if (known.size() > 2) names.push_back(known);
    }
  }
  const std::string near = suggestion(name[1] == '-' ? name : "-" + name, names);
  return name + ": gvx " + command.get_name() + " has no such flag" +
         (near.empty() ? help_of(command) : near);
}

/// The words behind the command's name.
std::optional<std::string> find_unknown_flags(const CLI::App& command, std::span<const std::string> words) {
  for (std::size_t i = 0; i < words.size(); ++i) {
    const std::string& word = words[i];
    if (word == "--") return std::nullopt;
    if (!is_flag(word)) continue;
    if (auto unknown = unknown_flag(command, word)) return unknown;
    const CLI::Option* option = find_flag(command, word);
    if (option == nullptr) continue;  // its value is in the word
    const int values = std::min(option->get_type_size_min(), option->get_items_expected_min());
    for (int value = 0; value < values; ++value) {
      ++i;
      if (i == words.size()) return word + ": expected a value, found the end of the line" + help_of(command);
      if (is_flag(words[i]) && find_flag(command, words[i].substr(0, words[i].find('='))) != nullptr) {
        return word + ": expected a value, found the flag " + words[i];
      }
    }
  }
  return std::nullopt;
}

/// The part of a text between two marks, the last of which may be empty for its end.
std::optional<std::string> between(const std::string& text, const std::string& before,
                                   const std::string& after) {
  const std::size_t start = text.find(before);
  if (start == std::string::npos) return std::nullopt;
  const std::size_t from = start + before.size(), end = after.empty() ? text.size() : text.find(after, from);
  if (end == std::string::npos) return std::nullopt;
  return text.substr(from, end - from);
}

/// The option that an error's text begins with or holds behind a colon.
const CLI::Option* option_of(const CLI::App& command, const std::string& name) {
  for (const CLI::Option* option : command.get_options()) {
    if (option->get_name() == name || option->get_name(true) == name) return option;
  }
  return nullptr;
}

std::string kind_of_number(const CLI::Option& option) {
  const std::string type = option.get_type_name();
  return type.starts_with("INT")    ? "a whole number"
         : type.starts_with("UINT") ? "a whole number, 0 or more"
                                    : "a number";
}

std::string explain_value(const CLI::Option& option, const std::string& text) {
  const std::string name = name_of(option), problem = text.substr(std::min(text.find(": ") + 2, text.size()));
  const std::string type = option.get_type_name();
  // The value is in the text; what the option takes is in its own description.
  if (const auto value = between(problem, "", " not in {")) {
    const std::string list = between(problem, " not in {", "}").value_or("");
    std::vector<std::string> names;
    for (std::size_t at = 0; at <= list.size();) {
      const std::size_t comma = std::min(list.find(',', at), list.size());
      names.push_back(list.substr(at, comma - at));
      at = comma + 1;
    }
    return name + ": '" + *value + "' is not " + joined(names, " or ") + suggestion(*value, names);
  }
  if (const auto value = between(problem, "Value ", " not in range")) {
    const auto least = between(type, " in [", " - "), most = between(type, " - ", "]");
    if (least && most) {
      return name + ": '" + *value + "' is not " + kind_of_number(option) + " from " + *least + " to " +
             *most;
    }
  }
  return name + ": " + problem;
}

std::string explain_in(const CLI::App& command, const CLI::ParseError& error) {
  const std::string text = error.what(), kind = error.get_name();
  if (kind == "RequiredError") {
    const CLI::Option* option = option_of(command, text.substr(0, text.find(" is required")));
    if (option != nullptr) return name_of(*option) + " is missing: " + usage(command) + help_of(command);
  }
  // Its name is that of the command.
  if (error.get_exit_code() == static_cast<int>(CLI::ExitCodes::ExtrasError)) {
    const auto extras = between(text, "expected: ", "");
    if (extras) return "more than was expected: '" + *extras + "'; " + usage(command) + help_of(command);
  }
  if (kind == "ConversionError") {
    const CLI::Option* option = option_of(command, between(text, "Could not convert: ", " = ").value_or(""));
    if (option != nullptr && !option->results().empty()) {
      return name_of(*option) + ": '" + option->results().front() + "' is not " + kind_of_number(*option);
    }
  }
  if (kind == "ExcludesError" || kind == "RequiresError") {
    const std::string verb = kind == "ExcludesError" ? " excludes " : " requires ";
    const std::string first = text.substr(0, text.find(verb)), second = between(text, verb, "").value_or("");
    return first + (kind == "ExcludesError" ? ": does not go with " : ": only with ") + second;
  }
  const CLI::Option* option = option_of(command, text.substr(0, text.find(": ")));
  if (option == nullptr) return text + help_of(command);
  if (kind == "ValidationError") return explain_value(*option, text);
  if (kind == "ArgumentMismatch") {
    const std::string count = std::to_string(option->results().size()),
                      most = std::to_string(option->get_items_expected_max());
    if (flag_names(*option).empty()) {
      return "at most " + most + " " + name_of(*option) + " arguments, found " + count + help_of(command);
    }
    return name_of(*option) + ": expected " + (most == "1" ? "once" : "at most " + most + " values") +
           ", found " + count + (most == "1" ? " times" : "");
  }
  return text + help_of(command);
}

}  // namespace

std::optional<std::string> find_unknown_words(const CLI::App& program, std::span<const std::string> words) {
  const std::vector<std::string> names = command_names(program);
  if (words.empty()) return "expected a command: " + joined(names, " or ") + help_of(program);
  if (is_flag(words[0])) {
    if (find_flag(program, words[0]) != nullptr) return std::nullopt;
    return words[0] + ": expected a command first: " + joined(names, " or ") + help_of(program);
  }
  for (const CLI::App* command : program.get_subcommands({})) {
    if (command->get_name() == words[0]) return find_unknown_flags(*command, words.subspan(1));
  }
  const std::string near = suggestion(words[0], names);
  return "'" + words[0] + "' is not a command (" + joined(names, " or ") + ")" +
         (near.empty() ? help_of(program) : near);
}

std::string explain(const CLI::App& program, const CLI::ParseError& error) {
  const std::vector<const CLI::App*> parsed = program.get_subcommands({});
  for (const CLI::App* command : parsed) {
    if (command->parsed()) return explain_in(*command, error);
  }
  return std::string(error.what()) + help_of(program);
}

}  // namespace gvx::app
