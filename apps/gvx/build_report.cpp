#include "build_report.h"

#include "messages.h"

namespace gvx::app {

void warn_of_build(const std::string& path, const io::VolumeDescription& volume,
                   const io::StoreBuildReport& report) {
  if (report.not_finite > 0) {
    warn(path + ": " + std::to_string(report.not_finite) +
         " samples are not finite numbers; they are stored as 0");
  }
  if (report.rounded) {
    warn(path + ": " + io::sample_name(volume.type) + " samples are stored as f32, to 24 bits");
  }
  for (const io::Surplus& surplus : report.surplus) {
    warn(surplus.path + ": " + (surplus.counted ? "" : "at least ") + std::to_string(surplus.bytes) +
         " more bytes than the volume has; they are not used");
  }
}

}  // namespace gvx::app
