/// \file
/// What nearly every source of the program includes and takes long to read, compiled once. Sources include
/// what they use all the same.
#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>
