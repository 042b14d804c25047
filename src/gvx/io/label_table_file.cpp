#include "gvx/io/label_table_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "gvx/core/text_file.h"
#include "gvx/io/header_text.h"

namespace gvx::io {
namespace {

constexpr double kMostInByte = 255;

struct Line {
  std::size_t number;  ///< from 1 on
  std::string_view text;
};

struct Column {
  std::optional<std::size_t> label, name, color, red, green, blue;

  /// Fields that a line must have for all of these columns.
  std::size_t fields() const {
    std::size_t count = 0;
    for (const auto& i : {label, name, color, red, green, blue}) count = std::max(count, i ? *i + 1 : 0);
    return count;
  }
};

class TableReader {
 public:
  TableReader(const std::string& path, std::vector<std::string>* warnings)
      : path_(path), warnings_(warnings) {}

  Result<scene::LabelTable> read(std::string_view text) {
    if (text.starts_with("\xef\xbb\xbf")) text.remove_prefix(3);
    std::vector<Line> lines;
    for (std::size_t number = 1; !text.empty(); ++number) {
      const std::string_view line = take_line(text);
      const std::string_view content = trimmed(line);
      if (!content.empty() && content.front() != '#') lines.push_back({number, line});
    }
    if (lines.empty()) return file_error(path_, "a table of labels holds none");
    const std::string_view first = lines.front().text;
    const char separator = first.find('\t') != std::string_view::npos  ? '\t'
                           : first.find(',') != std::string_view::npos ? ','
                                                                       : ' ';
    const bool begins_with_number = parse_integer(words(first).front()).has_value();
    if (separator != ' ' && !begins_with_number) {
      GVX_TRY(read_columns(lines, separator));
    } else {
      for (const Line& line : lines) GVX_TRY(read_words(line));
      if (first_named_ && first_colored_) {
        return wrong(*first_named_, "expected a colour, as line " + std::to_string(first_colored_->number) +
                                        " has, found " + quoted(trimmed(first_named_->text)));
      }
    }
    settle_fourth_numbers();
    return std::move(table_);
  }

 private:
  Error wrong(const Line& line, const std::string& what) const {
    return file_error(path_, "line " + std::to_string(line.number) + ": " + what);
  }
  Error wrong_layout(const Line& line) const {
    return wrong(line,
                 "expected NUMBER NAME RED GREEN BLUE (FreeSurfer), NUMBER RED GREEN BLUE OPACITY 0|1 "
                 "0|1 \"NAME\" (ITK-SNAP), or columns index, name, color; found " +
                     quoted(trimmed(line.text)));
  }

  Result<std::uint32_t> label_of(const Line& line, std::string_view text) const {
    const auto number = parse_integer(trimmed(text));
    if (!number || *number < 0 || *number > std::numeric_limits<std::uint32_t>::max()) {
      return wrong(line, "expected a label, a whole number from 0, found " + quoted(text));
    }
    return static_cast<std::uint32_t>(*number);
  }

  Result<Vec3d> color_of(const Line& line, std::span<const std::string_view> parts) const {
    Vec3d color;
    for (int c = 0; c < 3; ++c) {
      const std::string_view part = trimmed(parts[static_cast<std::size_t>(c)]);
      const auto value = parse_number(part);
      if (!value || !(*value >= 0 && *value <= kMostInByte) || std::trunc(*value) != *value) {
        return wrong(line,
                     "expected red, green and blue as whole numbers from 0 to 255, found " + quoted(part));
      }
      color[c] = *value / kMostInByte;
    }
    return color;
  }

  /// "#rrggbb", with or without the #.
  Result<Vec3d> hex_color_of(const Line& line, std::string_view text) const {
    std::string_view digits = trimmed(text);
    if (digits.starts_with('#')) digits.remove_prefix(1);
    const auto digit = [](char c) {
      return c >= '0' && c <= '9'   ? c - '0'
             : c >= 'a' && c <= 'f' ? c - 'a' + 10
             : c >= 'A' && c <= 'F' ? c - 'A' + 10
                                    : -1;
    };
    if (digits.size() != 6 ||
        std::any_of(digits.begin(), digits.end(), [&](char c) { return digit(c) < 0; })) {
      return wrong(line, "expected a colour as #rrggbb, found " + quoted(text));
    }
    Vec3d color;
    for (int c = 0; c < 3; ++c) {
      const auto at = static_cast<std::size_t>(2 * c);
      color[c] = (16 * digit(digits[at]) + digit(digits[at + 1])) / kMostInByte;
    }
    return color;
  }

  /// Lines that repeat another say nothing new. Two that contradict each other are an error, or a warning
  /// where the later one counts.
  Status add(const Line& line, std::uint32_t label, scene::LabelEntry entry, bool later_counts) {
    const auto [known, is_new] = lines_.emplace(label, Added{line.number, line.text});
    if (!is_new && trimmed(known->second.text) != trimmed(line.text)) {
      const std::string both = "label " + std::to_string(label) + " has a line already, line " +
                               std::to_string(known->second.number);
      if (!later_counts) return wrong(line, both + "; expected one line for each label");
      if (warnings_ != nullptr) warnings_->push_back(wrong(line, both + "; this one counts").message);
      known->second = {line.number, line.text};
    }
    table_[label] = std::move(entry);
    return {};
  }

  /// MRIcron's third word is the label again or a number of its own, above 255; another may be the beginning
  /// of a colour.
  static bool begins_color(std::span<const std::string_view> parts) {
    if (parts.size() < 3) return false;
    const auto number = parse_number(parts[2]);
    return number && *number >= 0 && *number <= kMostInByte && parts[2] != parts[0];
  }

  /// FreeSurfer's or ITK-SNAP's.
  Status read_words(const Line& line) {
    const std::vector<std::string_view> parts = words(line.text);
    const bool snap = parts.size() >= 8 && line.text.find('"') != std::string_view::npos;
    const bool named_only = parts.size() == 2 || parts.size() == 3;
    if (!snap && !named_only && parts.size() < 5) return wrong_layout(line);
    if (named_only && !parse_integer(parts[0])) return wrong_layout(line);
    GVX_ASSIGN(const std::uint32_t label, label_of(line, parts[0]));
    scene::LabelEntry entry;
    if (named_only) {
      if (begins_color(parts)) return wrong_layout(line);
      if (parts[1].starts_with('"') && line.text.find('"') == line.text.rfind('"'))
        return wrong(line, "expected a closing quotation mark");
      if (!first_named_) first_named_ = line;
      entry.name = std::string(parts[1]);
      return add(line, label, std::move(entry), false);
    }
    if (!first_colored_) first_colored_ = line;
    const std::size_t color_at = snap ? 1 : 2;
    if (!parse_number(parts[color_at])) return wrong_layout(line);
    GVX_ASSIGN(entry.color, color_of(line, std::span(parts).subspan(color_at, 3)));
    if (snap) {
      const auto opacity = parse_number(parts[4]);
      const auto visible = parse_integer(parts[5]);
      if (!opacity || !(*opacity >= 0 && *opacity <= 1)) {
        return wrong(line, "expected an opacity from 0 to 1, found " + quoted(parts[4]));
      }
      if (!visible) return wrong(line, "expected a visibility, 0 or 1, found " + quoted(parts[5]));
      entry.opacity = *visible == 0 ? 0 : *opacity;
      const std::size_t begin = line.text.find('"'), end = line.text.rfind('"');
      if (begin == end) return wrong(line, "expected a closing quotation mark");
      entry.name = std::string(line.text.substr(begin + 1, end - begin - 1));
    } else {
      entry.name = std::string(parts[1]);
      if (parts.size() > 5) {
        const auto fourth = parse_number(parts[5]);
        if (!fourth || !(*fourth >= 0 && *fourth <= kMostInByte)) {
          return wrong(line,
                       "expected a fourth number from 0 to 255 behind the colour, found " + quoted(parts[5]));
        }
        fourth_numbers_[label] = *fourth / kMostInByte;
      }
    }
    return add(line, label, std::move(entry), !snap);
  }

  /// The fields of a line of CSV or TSV (RFC 4180, but for line breaks within fields).
  Result<std::vector<std::string>> fields_of(const Line& line, char separator) const {
    const std::string_view text = line.text;
    std::vector<std::string> fields(1);
    bool in_quotes = false;
    for (std::size_t i = 0; i < text.size(); ++i) {
      const char c = text[i];
      if (c == '"' && in_quotes && i + 1 < text.size() && text[i + 1] == '"') {
        fields.back() += '"';
        ++i;
      } else if (c == '"') {
        in_quotes = !in_quotes;
      } else if (c == separator && !in_quotes) {
        fields.emplace_back();
      } else {
        fields.back() += c;
      }
    }
    if (in_quotes) return wrong(line, "expected a closing quotation mark");
    for (std::string& field : fields) field = std::string(trimmed(field));
    return fields;
  }

  Result<Column> find_columns(const Line& line, const std::vector<std::string>& names) const {
    Column column;
    for (std::size_t i = 0; i < names.size(); ++i) {
      const std::string name = lower_case(names[i]);
      // "label" beside "index" may be a name: the first of these counts.
      const bool is_label = name == "index" || name == "label" || name == "value" || name == "id";
      std::optional<std::size_t>* const which = is_label                              ? &column.label
                                                : name == "name"                      ? &column.name
                                                : name == "color" || name == "colour" ? &column.color
                                                : name == "r" || name == "red"        ? &column.red
                                                : name == "g" || name == "green"      ? &column.green
                                                : name == "b" || name == "blue"       ? &column.blue
                                                                                      : nullptr;
      if (which == nullptr) continue;
      if (!*which) {
        *which = i;
      } else if (!is_label || lower_case(names[**which]) == name) {
        return wrong(line, "expected each column once, found " + quoted(names[**which]) + " and " +
                               quoted(names[i]) + " as columns " + std::to_string(**which + 1) + " and " +
                               std::to_string(i + 1));
      }
    }
    if (!column.label) {
      return wrong(line, "expected columns index, name and color, found " + quoted(trimmed(line.text)));
    }
    const int parts =
        int{column.red.has_value()} + int{column.green.has_value()} + int{column.blue.has_value()};
    if (!column.color && parts != 0 && parts != 3) {
      return wrong(line,
                   "expected all of the columns r, g and b, or none, found " + quoted(trimmed(line.text)));
    }
    return column;
  }

  Status read_columns(const std::vector<Line>& lines, char separator) {
    GVX_ASSIGN(const std::vector<std::string> names, fields_of(lines.front(), separator));
    GVX_ASSIGN(const Column column, find_columns(lines.front(), names));
    for (const Line& line : std::span(lines).subspan(1)) {
      GVX_ASSIGN(const std::vector<std::string> fields, fields_of(line, separator));
      if (fields.size() < column.fields()) {
        return wrong(line, "expected " + std::to_string(names.size()) + " fields, as line " +
                               std::to_string(lines.front().number) + " has, found " +
                               std::to_string(fields.size()));
      }
      const auto field = [&](std::size_t i) { return std::string_view(fields[i]); };
      GVX_ASSIGN(const std::uint32_t label, label_of(line, field(*column.label)));
      scene::LabelEntry entry;
      if (column.name) entry.name = std::string(field(*column.name));
      if (column.color) {
        const std::string_view color = field(*column.color);
        // "n/a" is how BIDS says that there is none.
        if (!color.empty() && color != "n/a") {
          GVX_ASSIGN(entry.color, hex_color_of(line, color));
        }
      } else if (column.red && column.green && column.blue) {
        const std::array<std::string_view, 3> parts = {field(*column.red), field(*column.green),
                                                       field(*column.blue)};
        GVX_ASSIGN(entry.color, color_of(line, parts));
      }
      GVX_TRY(add(line, label, std::move(entry), false));
    }
    return {};
  }

  /// Transparency or opacity: see the header.
  void settle_fourth_numbers() {
    std::size_t most = 0;
    for (const auto& [label, number] : fourth_numbers_) most += label != 0 && number == 1 ? 1 : 0;
    const bool is_opacity =
        2 * most > fourth_numbers_.size() - std::min<std::size_t>(fourth_numbers_.count(0), 1);
    for (const auto& [label, number] : fourth_numbers_) {
      table_[label].opacity = is_opacity ? number : 1 - number;
    }
  }

  struct Added {
    std::size_t number;
    std::string_view text;
  };

  const std::string& path_;
  std::vector<std::string>* warnings_;
  std::optional<Line> first_named_, first_colored_;  // in a table of words
  std::map<std::uint32_t, Added> lines_;
  scene::LabelTable table_;
  std::map<std::uint32_t, double> fourth_numbers_;  ///< 0 to 1
};

}  // namespace

Result<scene::LabelTable> read_label_table(const std::string& path, std::vector<std::string>* warnings) {
  GVX_ASSIGN(const std::string text, read_text_file(path, "a table of labels"));
  if (text.find('\0') != std::string::npos)
    return file_error(path, "a table of labels is a text, this is not");
  return TableReader(path, warnings).read(text);
}

bool is_label_table_name(std::string_view name) {
  const std::string lower = lower_case(name);
  constexpr std::array<const char*, 7> kEndings = {".txt",  ".csv",   ".tsv",   ".lut",
                                                   ".ctbl", ".label", ".labels"};
  return std::any_of(kEndings.begin(), kEndings.end(), [&](const char* end) { return lower.ends_with(end); });
}

}  // namespace gvx::io
