#include "gvx/open/build_warnings.h"

namespace gvx::open {

void warn_of_build(const std::string& path, const io::VolumeDescription& volume,
                   const io::StoreBuildReport& report, const Warn& warn) {
  for (const std::string& remark : volume.remarks) warn(path + ": " + remark);
  for (const std::string& line : report.warnings(path, volume.type)) warn(line);
  for (const io::Surplus& surplus : report.surplus) {
    warn(surplus.path + ": " + (surplus.counted ? "" : "at least ") + std::to_string(surplus.bytes) +
         " more bytes than the volume has; they are not used");
  }
}

}  // namespace gvx::open
