/// \file
/// The bench's sections. Each prints as it goes, appends Markdown, and returns its JSON.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "scenes.h"

namespace gvx::bench {

struct Request {
  Folders folders;
  std::string only;              ///< scenes whose name holds this
  double samples_per_voxel = 2;  ///< of the engine's pictures of the table
  bool lit = true;               ///< those pictures, and their references
  std::string pictures;          ///< a folder for PNGs of all pictures, or empty
};

/// Is the scene asked for, and what is it called?
std::string scene_title(const SceneName& scene);
bool wanted(const Request& request, const SceneName& scene);

/// Writes the line to standard output and to the Markdown.
void say(std::string& markdown, const std::string& line);

/// Scene by view by variant: PSNR, SSIM, time and samples.
nlohmann::json bench_pictures(const Request& request, std::string& markdown);
/// Do pictures depend on where the faces of bricks are?
nlohmann::json bench_seams(const Request& request, std::string& markdown);
/// Does anything jump while the camera moves away?
nlohmann::json bench_zoom(const Request& request, std::string& markdown);

}  // namespace gvx::bench
