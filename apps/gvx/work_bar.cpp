#include "work_bar.h"

namespace gvx::app {

void WorkBar::show(const open::Work& work) {
  using Unit = open::Work::Unit;
  // The bytes of a volume are built in one piece.
  const bool alone = work.unit == Unit::bytes && !title_.empty();
  const std::string what = alone ? title_ : (title_.empty() ? "" : title_ + ": ") + work.what;
  if (!progress_ || shown_ != what) {
    const Progress::Unit unit = work.unit == Unit::bytes    ? Progress::Unit::bytes
                                : work.unit == Unit::voxels ? Progress::Unit::voxels
                                                            : Progress::Unit::none;
    progress_.emplace(shown_ = what, unit, quiet_);
  }
  progress_->show(work.done, work.all);
}

}  // namespace gvx::app
