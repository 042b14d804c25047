/// \file
/// The values of a volume as `gvx info` shows them: rows of text, and JSON.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <utility>
#include <vector>

#include "gvx/io/value_survey.h"

namespace gvx::app {

/// A name and what stands behind it; the name is empty for a line that goes on.
using Row = std::pair<std::string, std::string>;

/// Range, percentiles, values where they are few, what is no number, and a histogram of 50 columns.
std::vector<Row> value_rows(const io::ValueSummary& summary);

/// The same, with the histogram's counts.
nlohmann::json value_json(const io::ValueSummary& summary);

}  // namespace gvx::app
