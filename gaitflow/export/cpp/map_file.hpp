// Reads map.bin, what `gaitflow export --c` writes: docs/other-languages.md describes it byte by byte.
//
// The file is untrusted: sizes are checked before memory is taken, the checksum before a number is believed, and every
// index before it is used. Whatever is wrong is a MapError that names the file.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include "classifier.hpp"
#include "condensed.hpp"
#include "cursor.hpp"
#include "map_data.hpp"

namespace gaitflow {

namespace detail {

constexpr std::size_t checked_from = 16;
constexpr std::uint32_t known_format = 7;
constexpr double least_length = 1e-9;  // of what is divided by

// CRC-32 as in zlib and PNG.
inline std::uint32_t crc32(const unsigned char* bytes, std::size_t count) {
  std::array<std::uint32_t, 256> table{};
  for (std::uint32_t i = 0; i < 256; ++i) {
    std::uint32_t value = i;
    for (int bit = 0; bit < 8; ++bit) value = (value >> 1) ^ ((value & 1u) ? 0xEDB88320u : 0u);
    table[i] = value;
  }
  std::uint32_t crc = 0xFFFFFFFFu;
  for (std::size_t i = 0; i < count; ++i) crc = (crc >> 8) ^ table[(crc ^ bytes[i]) & 0xFFu];
  return crc ^ 0xFFFFFFFFu;
}

inline Space read_space(Cursor& file, const Layout& layout) {
  Space space;
  space.lower = file.bounds(layout.variables(), -1);
  space.upper = file.bounds(layout.variables(), 1);
  space.lower_rows = file.bounds(layout.rows, -1);
  space.upper_rows = file.bounds(layout.rows, 1);
  const auto bound = [&space](std::size_t place, double low, double high) {
    if (std::isfinite(low)) space.below.push_back(place);
    if (std::isfinite(high)) space.above.push_back(place);
  };
  for (std::size_t i = 0; i < space.lower.size(); ++i) {
    file.require(space.lower[i] <= space.upper[i], "a bound below lies above the one above");
    if (space.lower[i] == space.upper[i]) continue;
    bound(space.free.size(), space.lower[i], space.upper[i]);
    space.free.push_back(i);
  }
  for (std::size_t i = 0; i < space.lower_rows.size(); ++i) {
    const double low = space.lower_rows[i], high = space.upper_rows[i];
    file.require(low <= high, "a bound below lies above the one above");
    if (low == high) {
      space.equal.push_back(i);
    } else if (std::isfinite(low) || std::isfinite(high)) {
      bound(space.free.size() + space.unequal.size(), low, high);
      space.unequal.push_back(i);
    }
  }
  return space;
}

inline Task read_task(Cursor& file) {
  Task task;
  task.names.resize(file.count(1, 64, "a task has no parameters, or too many"));
  task.ranged.resize(file.count(1, std::min<std::size_t>(task.names.size(), 8), "the map has no axes, or too many"));
  for (std::string& name : task.names) name = file.text();
  file.require(std::count(task.names.begin(), task.names.end(), "cycle_duration") == 1, "a task has no cycle_duration");
  task.held = file.finite<double>(task.names.size());
  for (std::size_t i = 0; i < task.ranged.size(); ++i)
    task.ranged[i] = file.count(i == 0 ? 0 : task.ranged[i - 1] + 1, task.names.size() - 1, "an axis is no parameter");
  return task;
}

inline Domain read_domain(Cursor& file, std::size_t axes) {
  Domain domain;
  std::vector<std::size_t> sizes(axes);
  std::size_t tasks = 1;
  for (std::size_t& size : sizes) {
    size = file.count(1, 10000, "an axis of the domain is empty or too long");
    file.require(tasks <= most_bytes / size, "the domain has too many tasks");
    tasks *= size;
  }
  for (const std::size_t size : sizes) domain.axes.push_back(file.axis(size));
  domain.feasible = file.array<unsigned char>(tasks);
  return domain;
}

inline Layout read_layout(Cursor& file) {
  const char* fault = "the layout of the decision vector is not one";
  Layout layout;
  layout.phases = file.count(1, 64, fault);
  layout.knots_per_phase = file.count(1, 1000, fault);
  layout.legs.resize(file.count(1, 8, fault));
  layout.dimension = file.count(2, 3, fault);
  layout.base = file.count(1, 100, fault);
  layout.rows = file.count(1, 10000000, fault);
  layout.linear_forces = file.count(0, 1, fault) == 1;
  layout.energy = file.count(0, 1, fault) == 1;
  for (std::string& leg : layout.legs) leg = file.text();
  layout.shares = file.finite<double>(layout.knots_per_phase);
  layout.scale = file.finite<double>(layout.variables());
  return layout;
}

inline void read_gaits(Cursor& file, MapFile& map) {
  const std::size_t gaits = file.count(1, 4096, "there are no gaits, or too many");
  file.require(map.classifier.gaits() == gaits, "the classifier has other gaits than the map");
  for (std::size_t i = 0; i < gaits; ++i) {
    Gait gait;
    gait.name = file.text();
    gait.key = file.text();
    gait.pattern = file.text();
    gait.primal = file.finite<double>(map.layout.variables());
    gait.multipliers_bounds = file.finite<double>(map.layout.variables());
    gait.multipliers_rows = file.finite<double>(map.layout.rows);
    gait.space = read_space(file, map.layout);
    map.gaits.push_back(std::move(gait));
  }
}

inline Sheet read_sheet(Cursor& file, const MapFile& map) {
  const std::size_t axes = map.task.ranged.size();
  const Vector& steps = map.atlas.steps;
  Sheet sheet;
  sheet.gait = file.count(0, map.gaits.size() - 1, "a sheet of the atlas has a gait that the map has not");
  sheet.pattern = file.text();
  sheet.space = read_space(file, map.layout);
  sheet.nodes = file.count(1, 1000000, "a sheet of the atlas has no nodes, or too many");
  sheet.mode_count = file.count(1, 512, "a sheet of the atlas has no modes, or too many");
  const std::size_t size = file.count(0, 100000000, "a sheet of the atlas is too large");
  file.require((size == sheet.space.encoded() || size == condensed_size(sheet.space)) && !sheet.space.free.empty(),
               "a sheet of the atlas does not fit its pattern");
  sheet.infeasible_count = file.count(0, 1000000, "a sheet of the atlas has too many infeasible places");
  sheet.tear = file.finite<double>(1)[0];
  sheet.places = file.finite<double>(sheet.nodes * axes);
  sheet.infeasible = file.finite<double>(sheet.infeasible_count * axes);
  sheet.log_costs = file.finite<double>(sheet.nodes);
  sheet.slopes = file.finite<double>(sheet.nodes * axes);
  sheet.mean = file.finite<float>(size);
  sheet.modes = file.finite<float>(sheet.mode_count * size);
  sheet.coordinates = file.finite<float>(sheet.nodes * sheet.mode_count);
  const std::vector<float> tangents = file.finite<float>(sheet.nodes * axes * sheet.mode_count);
  sheet.tangents.assign(tangents.begin(), tangents.end());
  for (double& cost : sheet.log_costs) {
    file.require(cost > 0, "a cost is not positive");
    cost = std::log(cost);
  }
  for (std::size_t i = 0; i < sheet.places.size(); ++i) {
    sheet.places[i] /= steps[i % axes];
    sheet.slopes[i] *= steps[i % axes];
  }
  for (std::size_t i = 0; i < sheet.infeasible.size(); ++i) sheet.infeasible[i] /= steps[i % axes];
  for (std::size_t i = 0; i < sheet.tangents.size(); ++i) sheet.tangents[i] *= steps[i / sheet.mode_count % axes];
  sheet.by_first_axis.resize(sheet.nodes);
  std::iota(sheet.by_first_axis.begin(), sheet.by_first_axis.end(), std::size_t{0});
  std::stable_sort(sheet.by_first_axis.begin(), sheet.by_first_axis.end(), [&](std::size_t one, std::size_t other) {
    return sheet.places[one * axes] < sheet.places[other * axes];
  });
  return sheet;
}

inline void read_atlas(Cursor& file, MapFile& map) {
  Atlas& atlas = map.atlas;
  atlas.steps = file.finite<double>(map.task.ranged.size());
  for (const double step : atlas.steps) file.require(step >= least_length, "a step of the atlas is not positive");
  const Vector rule = file.finite<double>(5);
  atlas.barrier = rule[0], atlas.reach = rule[1], atlas.nearest = rule[2], atlas.support = rule[3];
  atlas.doubt = rule[4];
  file.require(atlas.barrier > 0 && atlas.reach >= least_length && atlas.nearest >= least_length,
               "the atlas' rule has a number that is not positive");
  const std::size_t sheets = file.count(0, 4096, "the atlas has too many sheets");
  for (std::size_t i = 0; i < sheets; ++i) atlas.sheets.push_back(read_sheet(file, map));
}

inline std::vector<unsigned char> read_bytes(const std::string& path) {
  std::ifstream file(path, std::ios::binary | std::ios::ate);
  const std::streamoff size = file ? static_cast<std::streamoff>(file.tellg()) : -1;
  if (size < 0) throw MapError(path + ": cannot be read; give the map.bin that `gaitflow export --c` wrote");
  if (size < static_cast<std::streamoff>(start_size) || size > static_cast<std::streamoff>(most_bytes))
    throw MapError(path + ": " + std::to_string(size) + " bytes; this is no map.bin");
  std::vector<unsigned char> bytes(static_cast<std::size_t>(size));
  file.seekg(0);
  if (!file.read(reinterpret_cast<char*>(bytes.data()), size)) throw MapError(path + ": cannot be read to its end");
  return bytes;
}

}  // namespace detail

// The whole of map.bin, checked. Throws MapError.
inline MapFile read_map(const std::string& path) {
  const std::uint16_t one = 1;
  unsigned char first;
  std::memcpy(&first, &one, 1);
  if (first != 1) throw MapError(path + ": is little-endian, this machine is not; the reader would have to swap bytes");
  const std::vector<unsigned char> bytes = detail::read_bytes(path);
  detail::Cursor file(path, bytes);
  std::uint32_t format, crc;
  std::uint64_t size;
  std::memcpy(&format, bytes.data() + 8, 4);
  std::memcpy(&crc, bytes.data() + 12, 4);
  std::memcpy(&size, bytes.data() + 16, 8);
  if (std::memcmp(bytes.data(), "gaitmap\n", 8) != 0) file.refuse("this is no map.bin");
  if (format != detail::known_format)
    file.refuse("has format " + std::to_string(format) + ", this reader knows format " +
                std::to_string(detail::known_format) + "; take the reader beside it");
  if (size != bytes.size())
    file.refuse(std::to_string(bytes.size()) + " bytes, but it should have " + std::to_string(size));
  if (crc != detail::crc32(bytes.data() + detail::checked_from, bytes.size() - detail::checked_from))
    file.refuse("its checksum is wrong: it is damaged");
  MapFile map;
  std::memcpy(map.manifest_sha256.data(), bytes.data() + 24, 32);
  map.scenario = file.text();
  map.version = file.text();
  map.task = detail::read_task(file);
  map.domain = detail::read_domain(file, map.task.ranged.size());
  map.layout = detail::read_layout(file);
  map.cost_scale = file.finite<double>(1)[0];
  file.require(map.cost_scale > 0, "the cost's scale is not positive");
  map.classifier = detail::read_classifier(file, map.task.ranged.size());
  detail::read_gaits(file, map);
  detail::read_atlas(file, map);
  if (!file.ended()) file.refuse("something follows after its end");
  return map;
}

}  // namespace gaitflow
