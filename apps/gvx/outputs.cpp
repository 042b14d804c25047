#include "outputs.h"

#include <filesystem>
#include <map>
#include <optional>
#include <tuple>
#include <utility>

#include <sys/stat.h>

#include "gvx/core/partial_file.h"

namespace gvx::app {
namespace {

namespace fs = std::filesystem;

/// Which file it is, whatever its name. Of a name that nothing stands behind yet: the folder, and the name in
/// it.
struct FileIdentity {
  dev_t device = 0;
  ino_t number = 0;
  std::string name = {};

  bool is_new() const { return !name.empty(); }
  bool operator<(const FileIdentity& other) const {
    return std::tie(device, number, name) < std::tie(other.device, other.number, other.name);
  }
};

/// Of a regular file.
std::optional<FileIdentity> identity_of(const std::string& path) {
  struct stat status {};
  // What comes through standard input may be a file as well.
  if (::stat(path == "-" ? "/dev/stdin" : path.c_str(), &status) != 0 || !S_ISREG(status.st_mode)) {
    return std::nullopt;
  }
  return FileIdentity{status.st_dev, status.st_ino};
}

std::optional<FileIdentity> identity_of_new(const std::string& path) {
  const fs::path place(path);
  const std::string folder = place.has_parent_path() ? place.parent_path().string() : ".";
  struct stat status {};
  if (::stat(folder.c_str(), &status) != 0) return std::nullopt;
  return FileIdentity{status.st_dev, status.st_ino, place.filename().string()};
}

/// Those of an output and of the unfinished file beside it; none of a device or a pipe.
std::vector<FileIdentity> identities_of(const OutputPlace& place) {
  std::vector<FileIdentity> identities;
  for (const std::string& path : {place.path, place.path + ".partial"}) {
    auto identity = identity_of(path);
    if (!identity && place.kind == OutputPlace::Kind::file) identity = identity_of_new(path);
    if (identity) identities.push_back(*identity);
    if (place.kind != OutputPlace::Kind::file) break;
  }
  return identities;
}

}  // namespace

Status check_outputs(std::span<const Output> outputs,
                     const std::function<std::vector<std::string>()>& inputs) {
  std::map<FileIdentity, std::string> read, written;
  bool inputs_known = false;
  const auto input_of = [&](const FileIdentity& identity) -> const std::string* {
    if (!std::exchange(inputs_known, true)) {
      for (const std::string& input : inputs()) {
        const auto of_input = identity_of(input);
        if (of_input) read.emplace(*of_input, input == "-" ? "standard input" : input);
      }
    }
    const auto found = read.find(identity);
    return found == read.end() ? nullptr : &found->second;
  };
  for (const Output& output : outputs) {
    const auto place = find_output(output.path);
    if (!place.ok()) {
      if (output.later) continue;
      return Error{output.flag + " " + place.error().message};
    }
    for (const FileIdentity& identity : identities_of(place.value())) {
      const std::string* input = identity.is_new() ? nullptr : input_of(identity);
      if (input != nullptr) {
        return Error{output.flag + " " + output.path + ": the output is the input" +
                     (*input == output.path ? "" : " " + *input)};
      }
      // What goes to standard output one after the other harms nothing.
      if (place.value().kind == OutputPlace::Kind::descriptor) continue;
      const auto [other, first] = written.emplace(identity, output.flag);
      if (!first)
        return Error{output.flag + " " + output.path + ": " + other->second + " names the same file"};
    }
  }
  for (const Output& output : outputs) {
    if (output.later) continue;
    if (const Status status = check_writable(output.path); !status.ok()) {
      return Error{output.flag + " " + status.error().message};
    }
  }
  return {};
}

Status check_is_file(const Output& output) {
  GVX_ASSIGN(const OutputPlace place, find_output(output.path));
  if (place.kind == OutputPlace::Kind::file) return {};
  return Error{output.flag + " " + output.path + ": expected the name of a file, found a device or a pipe"};
}

}  // namespace gvx::app
