#include "gvx/store/notes.h"

#include <algorithm>
#include <cstddef>
#include <nlohmann/json.hpp>
#include <span>
#include <string_view>

#include "gvx/store/sections.h"
#include "gvx/store/store_reader.h"
#include "gvx/store/store_writer.h"

namespace gvx::store {
namespace {

constexpr std::uint32_t kNotesVersion = 1;
constexpr std::uint64_t kMostNotesBytes = std::uint64_t{1} << 20;

/// Nothing where the JSON is not a colour.
std::optional<Vec3f> color_of(const nlohmann::json& json) {
  if (!json.is_array() || json.size() != 3) return std::nullopt;
  Vec3f color;
  for (int i = 0; i < 3; ++i) {
    const auto& part = json[static_cast<std::size_t>(i)];
    if (!part.is_number() || part.get<double>() < 0 || part.get<double>() > 1) return std::nullopt;
    color[i] = part.get<float>();
  }
  return color;
}

}  // namespace

Status write_notes(StoreWriter& writer, const VolumeNotes& notes) {
  if (notes.empty()) return {};
  nlohmann::json json = nlohmann::json::object();
  if (!notes.unit.empty()) json["unit"] = notes.unit;
  for (const ChannelNotes& channel : notes.channels) {
    nlohmann::json entry = nlohmann::json::object();
    if (!channel.name.empty()) entry["name"] = channel.name;
    if (channel.color) entry["color"] = {channel.color->x, channel.color->y, channel.color->z};
    json["channels"].push_back(entry);
  }
  const std::string text = json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
  if (text.size() > kMostNotesBytes) return {};
  return writer.add_section(kNotesSection, kNotesVersion, false, std::as_bytes(std::span(text)));
}

Result<VolumeNotes> read_notes(const StoreReader& reader) {
  const auto section = std::find_if(reader.sections().begin(), reader.sections().end(), [](const Section& s) {
    return s.name == kNotesSection && s.version == kNotesVersion;
  });
  if (section == reader.sections().end()) return VolumeNotes{};
  const StoreFile& file = reader.file();
  const auto wrong = [&] { return file.corrupt("the notes are not the JSON that gvx writes"); };
  if (section->bytes > kMostNotesBytes) return wrong();
  GVX_ASSIGN(const auto bytes, read_section(file, *section));
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  const auto json = nlohmann::json::parse(text, nullptr, false);
  if (!json.is_object()) return wrong();
  VolumeNotes notes;
  if (const auto unit = json.find("unit"); unit != json.end()) {
    if (!unit->is_string()) return wrong();
    notes.unit = unit->get<std::string>();
  }
  const auto channels = json.find("channels");
  if (channels == json.end()) return notes;
  if (!channels->is_array() || channels->size() != reader.info().format.channels()) return wrong();
  for (const auto& entry : *channels) {
    if (!entry.is_object()) return wrong();
    ChannelNotes& channel = notes.channels.emplace_back();
    if (const auto name = entry.find("name"); name != entry.end()) {
      if (!name->is_string()) return wrong();
      channel.name = name->get<std::string>();
    }
    if (const auto color = entry.find("color"); color != entry.end()) {
      channel.color = color_of(*color);
      if (!channel.color) return wrong();
    }
  }
  return notes;
}

}  // namespace gvx::store
