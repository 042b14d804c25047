// gvx info PATH: what is in a store or a volume file.

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "commands.h"
#include "gvx/io/header_text.h"
#include "gvx/io/mesh.h"
#include "gvx/io/volume_reader.h"
#include "gvx/produce/mesh_spool.h"
#include "gvx/store/store_reader.h"
#include "messages.h"
#include "open_scene.h"
#include "units.h"

namespace gvx::app {
namespace {

struct Options {
  std::string path;
  bool json = false;
  VolumeFlags volume;
};

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

Result<nlohmann::json> describe_store(const std::string& path) {
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
  j["scale"] = info.scale;
  j["offset"] = info.offset;
  j["n"] = info.shape.n;
  j["brick"] = info.shape.m;
  j["levels"] = info.shape.levels;
  j["border"] = info.border;
  j["no_data"] = info.no_data;
  j["codec"] = store::codec_name(info.codec);
  j["source"] = info.source;
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

Result<nlohmann::json> describe_volume(const std::string& path, const io::VolumeOptions& volume_options) {
  GVX_ASSIGN(const auto reader, io::open_volume(path, volume_options));
  const io::VolumeDescription& d = reader->description();
  nlohmann::json j = describe_place(d.dimensions, d.voxel_to_world, d.anatomical);
  j["format"] = "volume file";
  j["type"] = io::sample_name(d.type);
  j["content"] = d.colors ? "color" : "scalar";
  j["planes"] = d.components;
  j["scale"] = d.scale;
  j["offset"] = d.offset;
  j["sample_bytes"] = io::volume_bytes(d);
  if (d.frames > 1) {
    j["frames"] = d.frames;
    j["frame"] = d.frame;
  }
  if (!d.remarks.empty()) j["remarks"] = d.remarks;
  return j;
}

Result<nlohmann::json> describe_mesh(const std::string& path) {
  std::error_code error;
  const std::string folder = std::filesystem::temp_directory_path(error).string();
  GVX_ASSIGN(const auto mesh, produce::spool_mesh(path, folder.empty() ? "." : folder, 1ull << 30, {}));
  const produce::MeshSummary& summary = mesh->summary();
  return nlohmann::json{{"format", "mesh"},
                        {"vertices", summary.vertices},
                        {"triangles", summary.triangles},
                        {"dropped_triangles", summary.dropped},
                        {"doubled_triangles", summary.doubled},
                        {"colors", summary.colors},
                        {"closed", summary.closed()},
                        {"wound_alike", summary.inside == produce::InsideRule::winding},
                        {"unused", summary.unused},
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

void print(const std::string& path, const nlohmann::json& j) {
  std::printf("%s\n", one_line(path).c_str());
  const auto row = [](const char* name, const std::string& value) {
    std::printf("  %-12s %s\n", name, value.c_str());
  };
  row("format", j["format"]);
  if (j.contains("triangles")) {
    row("triangles",
        j["triangles"].dump() + ", and " + j["dropped_triangles"].dump() + " that cover nothing" +
            (j["doubled_triangles"] != 0 ? ", " + j["doubled_triangles"].dump() + " there twice" : ""));
    row("vertices", j["vertices"].dump() + (j["colors"] ? ", with colours" : ""));
    row("surface", !j["closed"] ? "open" : j["wound_alike"] ? "closed" : "closed, faces not wound alike");
    row("from", joined(j["minimum"], ", "));
    row("to", joined(j["maximum"], ", "));
    std::string unused;
    for (const std::string what : j["unused"]) unused += (unused.empty() ? "" : ", ") + what;
    if (!unused.empty()) row("not used", unused);
    return;
  }
  row("voxels", joined(j["dimensions"], " x ") + " " + j["type"].get<std::string>());
  if (j["content"] != "scalar" || j["planes"] != 1) {
    row("content", j["content"].get<std::string>() + ", " + j["planes"].dump() + " numbers a voxel");
  }
  row("spacing",
      joined(j["spacing"], ", ") + (j["anatomical"] ? " mm, patient space (x right, y front, z up)" : ""));
  if (j.contains("frames")) {
    row("frames",
        j["frames"].dump() + ", of which this is " + j["frame"].dump() + " (--time chooses another)");
  }
  if (j.contains("remarks")) {
    for (const std::string remark : j["remarks"]) row("note", remark);
  }
  if (j.contains("value_range")) row("values", joined(j["value_range"], " to "));
  if (j["scale"] != 1.0 || j["offset"] != 0.0) {
    row("physical", number(j["scale"]) + " * stored + " + number(j["offset"]));
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

}  // namespace

Command add_info(CLI::App& program) {
  auto options = std::make_shared<Options>();
  CLI::App* command = program.add_subcommand("info", "Say what is in a store, a volume file or a mesh");
  command
      ->add_option("path", options->path,
                   "A .gvx store, a RAW, NRRD, NIfTI or MetaImage file, or a mesh (PLY, OBJ, STL, glTF)")
      ->required();
  command->add_flag("--json", options->json, "As JSON");
  options->volume.add_to(*command);
  return [options]() -> Status {
    GVX_ASSIGN(const bool store, is_store(options->path));
    GVX_ASSIGN(const io::VolumeOptions volume_options, options->volume.parse());
    const bool mesh = !store && io::is_mesh_name(options->path);
    if (mesh && options->volume.given()) return options->volume.refuse(options->path);
    GVX_ASSIGN(const nlohmann::json j, store  ? describe_store(options->path)
                                       : mesh ? describe_mesh(options->path)
                                              : describe_volume(options->path, volume_options));
    if (options->json) {
      std::printf("%s\n", j.dump(2, ' ', false, nlohmann::json::error_handler_t::replace).c_str());
    } else {
      print(options->path, j);
    }
    return {};
  };
}

}  // namespace gvx::app
