#include "frames.h"

#include <cstdio>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>
#include <sstream>

namespace gvx::bench {
namespace {

Vec3d vec3(const nlohmann::json& list) {
  return {list.at(0).get<double>(), list.at(1).get<double>(), list.at(2).get<double>()};
}

PeerView view_of(const nlohmann::json& json) {
  PeerView view;
  view.width = json.at("size").at(0).get<std::uint32_t>();
  view.height = json.at("size").at(1).get<std::uint32_t>();
  const auto& camera = json.at("camera");
  view.camera.eye = vec3(camera.at("eye"));
  view.camera.target = vec3(camera.at("target"));
  view.camera.up = vec3(camera.at("up"));
  view.camera.fov_degrees = camera.at("fov").get<double>();
  const auto& function = json.at("functions").at(0);
  for (const auto& point : function.at("colors")) {
    const Vec3d color{point.at(1).get<double>(), point.at(2).get<double>(), point.at(3).get<double>()};
    view.function.colors.push_back({point.at(0).get<double>(), color});
  }
  for (const auto& point : function.at("opacities")) {
    view.function.opacities.push_back({point.at(0).get<double>(), point.at(1).get<double>()});
  }
  const auto& lighting = json.at("lighting");
  view.lighting.enabled = lighting.at("enabled").get<bool>();
  view.lighting.ambient = lighting.at("ambient").get<float>();
  view.lighting.diffuse = lighting.at("diffuse").get<float>();
  view.lighting.specular = lighting.at("specular").get<float>();
  view.lighting.shininess = lighting.at("shininess").get<float>();
  view.lighting.lights = 1;
  view.lighting.light[0].kind = scene::LightKind::camera;
  view.lighting.light[0].place = vec3(lighting.at("lights").at(0).at("place"));
  return view;
}

Status save(const std::string& path, const std::vector<std::uint8_t>& bytes) {
  std::ofstream out(path, std::ios::binary);
  out.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  if (!out.flush()) return Error{path + ": cannot be written"};
  return {};
}

/// What is to be done, and the answer to it.
Result<std::string> answer(PeerSystem& system, PeerView& view, bool& aside, const std::string& line) {
  std::istringstream words(line);
  std::string what, rest;
  words >> what >> std::ws;
  std::getline(words, rest);
  if (what == "view") {
    GVX_ASSIGN(view, read_view(rest));
    GVX_TRY(system.look(view));
    GVX_TRY(system.frame(view.camera));
    aside = false;
    return std::string("ok");
  }
  if (what == "frame") {
    aside = !aside;
    GVX_ASSIGN(const double milliseconds, system.frame(aside ? moved_aside(view.camera) : view.camera));
    return std::to_string(milliseconds);
  }
  if (what == "save") {
    GVX_TRY(save(rest, system.rgb()));
    return std::string("ok");
  }
  return Error{"standard input: \"" + line + "\" is not view, frame or save"};
}

}  // namespace

Result<PeerView> read_view(const std::string& path) {
  std::ifstream in(path);
  if (!in) return Error{path + ": cannot be read"};
  try {
    return view_of(nlohmann::json::parse(in));
  } catch (const nlohmann::json::exception& error) {
    return Error{path + ": " + error.what()};
  }
}

scene::Camera moved_aside(scene::Camera camera) {
  const Vec3d aside = kHair * normalize(cross(camera.target - camera.eye, camera.up));
  camera.eye = camera.eye + aside;
  camera.target = camera.target + aside;
  return camera;
}

int serve(PeerSystem& system) {
  PeerView view;
  bool aside = false;
  for (std::string line; std::getline(std::cin, line);) {
    const auto said = answer(system, view, aside, line);
    if (!said.ok()) {
      std::fprintf(stderr, "%s\n", said.error().message.c_str());
      return 1;
    }
    std::cout << said.value() << std::endl;
  }
  return 0;
}

}  // namespace gvx::bench
