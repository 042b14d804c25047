// gvx info PATH: what is in a store or a volume file.

#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "commands.h"
#include "field_flags.h"
#include "gvx/io/header_text.h"
#include "gvx/io/mesh.h"
#include "gvx/io/value_survey.h"
#include "gvx/io/volume_reader.h"
#include "gvx/mesh/mesh_spool.h"
#include "gvx/open/open_volume.h"
#include "gvx/store/notes.h"
#include "gvx/store/store_reader.h"
#include "gvx/surface/surface_reader.h"
#include "messages.h"
#include "progress.h"
#include "units.h"
#include "value_rows.h"

namespace gvx::app {
namespace {

struct Options {
  std::string path;
  bool json = false, values = false, header = false;
  VolumeFlags volume;
};

// Samples of a volume file that are read without being asked for: they take seconds at most.
constexpr std::uint64_t kReadUnasked = std::uint64_t{1} << 30;

std::vector<double> list(Vec3d v) {
  return {v.x, v.y, v.z};
}

Vec3d spacing_of(const Affine3& voxel_to_world) {
  return {length(voxel_to_world.column[0]), length(voxel_to_world.column[1]),
          length(voxel_to_world.column[2])};
}

nlohmann::json describe_place(const Vec3i& dimensions, const Affine3& place, bool anatomical) {
  return {{"dimensions", {dimensions.x, dimensions.y, dimensions.z}},
          {"spacing", list(spacing_of(place))},
          {"voxel_to_world",
           {list(place.column[0]), list(place.column[1]), list(place.column[2]), list(place.origin)}},
          {"anatomical", anatomical}};
}

/// Their names and colours, where the file says something of them.
template <typename Channel>
void add_channels(nlohmann::json& j, const std::vector<Channel>& channels) {
  for (const Channel& channel : channels) {
    nlohmann::json entry = {{"name", channel.name}};
    if (channel.color) entry["color"] = list(Vec3d(*channel.color));
    j["channels"].push_back(entry);
  }
}

Result<nlohmann::json> describe_store(const std::string& path, std::vector<io::ValueSummary>& summaries) {
  GVX_ASSIGN(const auto reader, store::StoreReader::open(path));
  const store::VolumeInfo& info = reader->info();
  nlohmann::json j = describe_place(info.shape.dimensions, info.voxel_to_world, info.anatomical);
  std::error_code error;
  j["format"] = "gvx store, version " + std::to_string(reader->version());
  j["type"] = voxel_name(info.format.type);
  j["content"] = content_name(info.format.content);
  j["planes"] = info.format.planes;
  const double ends[2] = {info.scale * info.ranges.channel[0].minimum + info.offset,
                          info.scale * info.ranges.channel[0].maximum + info.offset};
  j["value_range"] = {std::min(ends[0], ends[1]), std::max(ends[0], ends[1])};
  const auto voxels = static_cast<std::uint64_t>(info.shape.dimensions.x) *
                      static_cast<std::uint64_t>(info.shape.dimensions.y) *
                      static_cast<std::uint64_t>(info.shape.dimensions.z);
  for (std::size_t channel = 0; channel < info.histograms.size(); ++channel) {
    summaries.push_back(io::summary_of_bins(info.ranges.channel[channel], info.histograms[channel], voxels,
                                            info.format.type != VoxelType::f32, info.scale, info.offset));
  }
  j["scale"] = info.scale;
  j["offset"] = info.offset;
  j["n"] = info.shape.n;
  j["brick"] = info.shape.m;
  j["levels"] = info.shape.levels;
  j["border"] = info.border;
  j["no_data"] = info.no_data;
  j["up"] = kUpAxisNames[static_cast<std::size_t>(info.up)];
  j["codec"] = store::codec_name(info.codec);
  j["source"] = info.source;
  GVX_ASSIGN(const store::VolumeNotes notes, store::read_notes(*reader));
  if (!notes.unit.empty()) j["unit"] = notes.unit;
  add_channels(j, notes.channels);
  j["file_bytes"] = std::filesystem::file_size(path, error);
  j["sections"] = nlohmann::json::array();
  for (const store::Section& section : reader->sections()) {
    j["sections"].push_back({{"name", section.name},
                             {"version", section.version},
                             {"required", section.required},
                             {"bytes", section.bytes}});
  }
  return j;
}

Result<nlohmann::json> describe_surface(const std::string& path) {
  GVX_ASSIGN(const auto reader, surface::SurfaceReader::open(path));
  const surface::SurfaceInfo& info = reader->info();
  std::uint64_t bricks = 0;
  for (std::uint32_t level = 0; level < info.levels; ++level) bricks += reader->nodes(level);
  return nlohmann::json{{"format", "gvx surface store, version " + std::to_string(surface::kSurfaceVersion)},
                        {"triangles", info.triangles},
                        {"levels", info.levels},
                        {"bricks", bricks},
                        {"cell", length(info.cells_to_world.column[0])},
                        {"minimum", list(info.cells_to_world.point(info.bounds.minimum))},
                        {"maximum", list(info.cells_to_world.point(info.bounds.maximum))},
                        {"up", kUpAxisNames[static_cast<std::size_t>(info.up)]},
                        {"codec", store::codec_name(info.codec)},
                        {"source", info.source},
                        {"file_bytes", reader->file().size_bytes()}};
}

nlohmann::json describe_volume(const io::VolumeDescription& d) {
  nlohmann::json j = describe_place(d.dimensions, d.voxel_to_world, d.anatomical);
  j["format"] = "volume file";
  j["type"] = io::sample_name(d.type);
  j["content"] = d.colors ? "color" : d.labels ? "labels" : "scalar";
  j["planes"] = d.components;
  j["scale"] = d.scale;
  j["offset"] = d.offset;
  j["sample_bytes"] = io::volume_bytes(d);
  if (!d.unit.empty()) j["unit"] = d.unit;
  add_channels(j, d.channels);
  if (d.frames > 1) {
    j["frames"] = d.frames;
    j["frame"] = d.frame;
  }
  if (!d.remarks.empty()) j["remarks"] = d.remarks;
  for (const io::SeriesDescription& series : d.series) {
    j["series"].push_back({{"number", series.number},
                           {"uid", series.uid},
                           {"modality", series.modality},
                           {"description", series.description},
                           {"dimensions", {series.dimensions.x, series.dimensions.y, series.dimensions.z}},
                           {"frames", series.frames}});
  }
  return j;
}

Result<nlohmann::json> describe_mesh(const std::string& path) {
  std::error_code error;
  const std::string folder = std::filesystem::temp_directory_path(error).string();
  Progress progress("reading", Progress::Unit::none);
  GVX_ASSIGN(const auto mesh,
             mesh::spool_mesh(path, folder.empty() ? "." : folder, 1ull << 30,
                              [&](std::uint64_t done, std::uint64_t all) { progress.show(done, all); }));
  const mesh::MeshSummary& summary = mesh->summary();
  const io::MeshUp up = io::mesh_up(path, summary.bounds);
  return nlohmann::json{{"format", "mesh"},
                        {"vertices", summary.vertices},
                        {"triangles", summary.triangles},
                        {"dropped_triangles", summary.dropped},
                        {"doubled_triangles", summary.doubled},
                        {"colors", summary.colors},
                        {"closed", summary.closed()},
                        {"wound_alike", summary.inside == mesh::InsideRule::winding},
                        {"unused", summary.unused},
                        {"up", kUpAxisNames[static_cast<std::size_t>(up.axis)]},
                        {"up_guessed", up.guessed},
                        {"up_why", up.why},
                        {"minimum", list(summary.bounds.minimum)},
                        {"maximum", list(summary.bounds.maximum)}};
}

/// A whole number without a point, whatever its type.
std::string number(const nlohmann::json& j) {
  return j.is_number_float() ? io::number_text(j.get<double>()) : j.dump();
}

std::string joined(const nlohmann::json& list, const char* separator) {
  std::string text;
  for (const auto& v : list) text += (text.empty() ? "" : separator) + number(v);
  return text;
}

/// "DAPI (0, 0, 1), GFP".
std::string channels_text(const nlohmann::json& channels) {
  std::string text;
  for (const auto& channel : channels) {
    const std::string name = channel["name"].get<std::string>();
    text += (text.empty() ? "" : ", ") + (name.empty() ? "no name" : one_line(name));
    if (channel.contains("color")) text += " (" + joined(channel["color"], ", ") + ")";
  }
  return text;
}

void row(const char* name, const std::string& value) {
  std::printf("  %-12s %s\n", name, value.c_str());
}

/// What the numbers of a voxel are, by their place among so many.
std::string channel_name(const nlohmann::json& j, std::size_t channel, std::size_t channels) {
  if (j.contains("channels") && channel < j["channels"].size()) {
    const std::string name = j["channels"][channel]["name"];
    if (!name.empty()) return one_line(name);
  }
  const std::string content = j["content"];
  constexpr const char* kColors[] = {"red", "green", "blue", "opacity"};
  if (content != "color" && content != "color+normal") return "channel " + std::to_string(channel + 1);
  return channels == 1 ? "opacity" : kColors[std::min<std::size_t>(channel, 3)];
}

void print_values(const nlohmann::json& j, const std::vector<io::ValueSummary>& summaries) {
  for (std::size_t channel = 0; channel < summaries.size(); ++channel) {
    if (summaries.size() > 1 || j["content"] == "color" || j["content"] == "color+normal") {
      std::printf("  %s\n", channel_name(j, channel, summaries.size()).c_str());
    }
    for (const auto& [name, value] : value_rows(summaries[channel])) row(name.c_str(), value);
  }
}

void print_surface(const nlohmann::json& j) {
  row("triangles", j["triangles"].dump());
  row("tree",
      j["bricks"].dump() + " bricks in " + j["levels"].dump() + " levels, " + j["codec"].get<std::string>());
  row("cell", number(j["cell"]) + ", of the finest level");
  row("from", joined(j["minimum"], ", "));
  row("to", joined(j["maximum"], ", "));
  row("up", j["up"]);
  row("source", one_line(j["source"].get<std::string>()));
  row("file", bytes_text(j["file_bytes"]));
}

void print(const std::string& path, const nlohmann::json& j) {
  std::printf("%s\n", one_line(path).c_str());
  row("format", j["format"]);
  if (j.contains("cell")) return print_surface(j);
  if (j.contains("triangles")) {
    row("triangles",
        j["triangles"].dump() + ", and " + j["dropped_triangles"].dump() + " that cover nothing" +
            (j["doubled_triangles"] != 0 ? ", " + j["doubled_triangles"].dump() + " of them twice" : ""));
    row("vertices", j["vertices"].dump() + (j["colors"] ? ", with colours" : ""));
    row("surface", !j["closed"]       ? "open"
                   : j["wound_alike"] ? "closed"
                                      : "closed, but its faces do not all point outwards");
    row("from", joined(j["minimum"], ", "));
    row("to", joined(j["maximum"], ", "));
    row("up", j["up"].get<std::string>() + ", " + j["up_why"].get<std::string>() +
                  (j["up_guessed"] ? " (--up of render and build overrides it)" : ""));
    std::string unused;
    for (const std::string what : j["unused"]) unused += (unused.empty() ? "" : ", ") + what;
    if (!unused.empty()) row("not used", unused);
    return;
  }
  row("voxels", joined(j["dimensions"], " x ") + " " + j["type"].get<std::string>());
  if (j["content"] != "scalar" || j["planes"] != 1) {
    row("content", j["content"].get<std::string>() + ", " + j["planes"].dump() + " numbers a voxel");
  }
  // Six digits are what headers mean: 1.0000000130496645 is 1.
  std::string spacing;
  for (const double edge : j["spacing"]) {
    std::array<char, 32> text{};
    std::snprintf(text.data(), text.size(), "%.6g", edge);
    spacing += (spacing.empty() ? "" : ", ") + std::string(text.data());
  }
  row("spacing", spacing + (j["anatomical"]      ? " mm, patient space (x right, y front, z up)"
                            : j.contains("unit") ? " " + one_line(j["unit"].get<std::string>())
                                                 : ""));
  if (j.contains("channels")) row("channels", channels_text(j["channels"]));
  if (j.contains("up") && j["up"] != "z") row("up", j["up"]);
  if (j.contains("frames")) {
    row("frames", j["frames"].dump() + " in time; frame " + j["frame"].dump() + " is shown (--time)");
  }
  if (j.contains("remarks")) {
    for (const std::string remark : j["remarks"]) row("note", remark);
  }
  if (j.contains("series")) {
    for (const auto& series : j["series"]) {
      std::string what = series["modality"];
      for (const char* field : {"description", "uid"}) {
        if (series[field] != "") what += (what.empty() ? "" : ", ") + one_line(series[field]);
      }
      row("series", one_line(series["number"]) + ": " + joined(series["dimensions"], " x ") +
                        (series["frames"] != 1 ? " x " + series["frames"].dump() + " frames" : "") +
                        (what.empty() ? "" : " (" + what + ")"));
    }
  }
  if (j["scale"] != 1.0 || j["offset"] != 0.0) {
    const bool minus = j["offset"] < 0.0;
    row("physical", number(j["scale"]) + " * stored" + (minus ? " - " : " + ") +
                        (minus ? number(-j["offset"].get<double>()) : number(j["offset"])));
  }
  if (j.contains("levels")) {
    row("tree", j["levels"].dump() + " levels of N = " + j["n"].dump() + ", bricks of " + j["brick"].dump() +
                    " voxels and a border of " + j["border"].dump() + ", " + j["codec"].get<std::string>());
    if (j["no_data"]) row("no data", "voxels that are NaN");
    row("source", j["source"]);
    row("file", bytes_text(j["file_bytes"]));
    std::string sections;
    for (const auto& section : j["sections"]) {
      sections += (sections.empty() ? "" : ", ") + section["name"].get<std::string>() + " " +
                  bytes_text(section["bytes"]);
    }
    row("sections", sections);
  } else {
    row("samples", bytes_text(j["sample_bytes"]));
  }
}

void print_json(nlohmann::json j, const std::vector<io::ValueSummary>& summaries) {
  // Beside a channel's name and colour, if it has any.
  for (std::size_t channel = 0; channel < summaries.size(); ++channel) {
    j["channels"][channel].update(value_json(summaries[channel]));
  }
  std::printf("%s\n", j.dump(2, ' ', false, nlohmann::json::error_handler_t::replace).c_str());
}

/// The header first: to read the values may take a while, or fail.
Status info_of_volume(const Options& o, const io::VolumeOptions& volume) {
  GVX_ASSIGN(const auto reader, io::open_volume(o.path, volume));
  const nlohmann::json j = describe_volume(reader->description());
  if (!o.json) print(o.path, j);
  const std::uint64_t bytes = io::volume_bytes(reader->description());
  // A pipe may have more to say to another reader, and its writer time.
  const bool reads = o.values || (!o.header && bytes <= kReadUnasked && reader->can_rewind());
  std::vector<io::ValueSummary> summaries;
  if (reads) {
    std::fflush(stdout);
    Progress progress("reading values", Progress::Unit::bytes);
    GVX_ASSIGN(summaries, io::survey_values(*reader, [&](std::uint64_t done, std::uint64_t all) {
                 progress.show(done, all);
               }));
  } else if (!o.json) {
    row("values", o.header ? "not read" : "not read (--values reads them, " + bytes_text(bytes) + ")");
  }
  if (o.json) {
    print_json(j, summaries);
  } else {
    print_values(j, summaries);
  }
  return {};
}

Status info(const Options& o) {
  GVX_ASSIGN(const bool store, open::is_store(o.path));
  GVX_ASSIGN(const io::VolumeOptions volume, o.volume.parse());
  const bool mesh = !store && io::is_mesh_name(o.path);
  if (mesh && o.volume.given()) return o.volume.refuse(o.path);
  if (!store && !mesh) return info_of_volume(o, volume);
  std::vector<io::ValueSummary> summaries;
  if (store && surface::is_surface_store(o.path)) {
    GVX_ASSIGN(const nlohmann::json j, describe_surface(o.path));
    if (o.json) {
      print_json(j, {});
    } else {
      print(o.path, j);
    }
    return {};
  }
  GVX_ASSIGN(const nlohmann::json j, store ? describe_store(o.path, summaries) : describe_mesh(o.path));
  if (o.json) {
    print_json(j, summaries);
  } else {
    print(o.path, j);
    if (store) print_values(j, summaries);
  }
  return {};
}

}  // namespace

Command add_info(CLI::App& program) {
  auto options = std::make_shared<Options>();
  CLI::App* command = program.add_subcommand("info", "Describe a store, a volume file, a folder or a mesh");
  command
      ->add_option(
          "path", options->path,
          "A .gvx store, a RAW, NRRD, NIfTI, MetaImage, TIFF or DICOM file, a folder of TIFF slices or "
          "DICOM files, or a mesh (PLY, OBJ, STL, glTF)")
      ->required();
  command->add_flag("--json", options->json, "Print JSON");
  CLI::Option* header = command->add_flag("--header", options->header,
                                          "Do not read the values of a volume file, only its header");
  command
      ->add_flag("--values", options->values,
                 "Read the values of a volume file of any size (default: up to 1 GiB)")
      ->excludes(header);
  options->volume.add_to(*command);
  return [options] { return info(*options); };
}

}  // namespace gvx::app
