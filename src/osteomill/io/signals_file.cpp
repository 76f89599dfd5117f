// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/signals_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <set>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/io/hdf5_handle.hpp"
#include "osteomill/io/text_file.hpp"

namespace osteomill::io {
namespace {

using hdf5::Handle;
using hdf5::ok;

constexpr const char* kFormat = "osteomill-signals";
constexpr std::int64_t kVersion = 1;
constexpr unsigned kDeflate = 4;

Handle string_type() {
  Handle type(H5Tcopy(H5T_C_S1), H5Tclose, "text type");
  ok(H5Tset_size(type, H5T_VARIABLE), "text type");
  ok(H5Tset_cset(type, H5T_CSET_UTF8), "text type");
  return type;
}

void put(hid_t at, const std::string& name, hid_t type, hid_t space, const void* value) {
  const Handle attribute(H5Acreate2(at, name.c_str(), type, space, H5P_DEFAULT, H5P_DEFAULT),
                         H5Aclose, name);
  ok(H5Awrite(attribute, type, value), name);
}

void put(hid_t at, const std::string& name, const std::string& value) {
  const Handle space(H5Screate(H5S_SCALAR), H5Sclose, name);
  const char* text = value.c_str();
  put(at, name, string_type(), space, &text);
}

void put(hid_t at, const std::string& name, double value) {
  const Handle space(H5Screate(H5S_SCALAR), H5Sclose, name);
  put(at, name, H5T_NATIVE_DOUBLE, space, &value);
}

void put(hid_t at, const std::string& name, std::int64_t value) {
  const Handle space(H5Screate(H5S_SCALAR), H5Sclose, name);
  put(at, name, H5T_NATIVE_INT64, space, &value);
}

void put(hid_t at, const std::string& name, const geometry::Vector3& value) {
  const hsize_t three = 3;
  const Handle space(H5Screate_simple(1, &three, nullptr), H5Sclose, name);
  put(at, name, H5T_NATIVE_DOUBLE, space, value.data());
}

void put_all(hid_t at, const SignalAttributes& attributes) {
  for (const auto& [name, value] : attributes)
    std::visit([&, &key = name](const auto& v) { put(at, key, v); }, value);
}

Handle group(hid_t at, const std::string& name) {
  return {H5Gcreate2(at, name.c_str(), H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT), H5Gclose, name};
}

/// A packed data set of the whole array.
Handle data_set(hid_t at, const std::string& name, hid_t type, const std::vector<hsize_t>& size,
                const void* values) {
  const Handle space(H5Screate_simple(static_cast<int>(size.size()), size.data(), nullptr),
                     H5Sclose, name);
  const Handle settings(H5Pcreate(H5P_DATASET_CREATE), H5Pclose, name);
  // No times of day in the file: the same run gives the same bytes.
  ok(H5Pset_obj_track_times(settings, false), name);
  std::vector<hsize_t> chunk = size;
  for (hsize_t& side : chunk) side = std::clamp<hsize_t>(side, 1, size.size() == 1 ? 65536 : 64);
  const bool empty = std::find(size.begin(), size.end(), 0u) != size.end();
  if (!empty) {
    ok(H5Pset_chunk(settings, static_cast<int>(chunk.size()), chunk.data()), name);
    ok(H5Pset_shuffle(settings), name);
    ok(H5Pset_deflate(settings, kDeflate), name);
  }
  Handle set(H5Dcreate2(at, name.c_str(), type, space, H5P_DEFAULT, settings, H5P_DEFAULT),
             H5Dclose, name);
  if (!empty) ok(H5Dwrite(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values), name);
  return set;
}

void write_run(hid_t file, const SignalRun& run) {
  const Handle here = group(file, run.name);
  put_all(here, run.attributes);
  for (const Signal& signal : run.signals) {
    const Handle set = data_set(here, signal.name, H5T_NATIVE_DOUBLE, {signal.values.size()},
                                signal.values.data());
    put(set, "unit", signal.unit);
    put(set, "about", signal.about);
  }
  const Handle events = group(here, "events");
  std::vector<double> times;
  std::vector<const char*> texts;
  for (const SignalEvent& event : run.events) {
    times.push_back(event.time_s);
    texts.push_back(event.text.c_str());
  }
  data_set(events, "time_s", H5T_NATIVE_DOUBLE, {times.size()}, times.data());
  data_set(events, "text", string_type(), {texts.size()}, texts.data());
  const Handle grids = group(here, "grids");
  for (const SignalGrid& grid : run.grids) {
    const geometry::GridShape& shape = grid.values.shape();
    const Handle set =
        data_set(grids, grid.name, H5T_NATIVE_FLOAT,
                 {static_cast<hsize_t>(shape.size[2]), static_cast<hsize_t>(shape.size[1]),
                  static_cast<hsize_t>(shape.size[0])},
                 grid.values.values().data());
    put(set, "unit", grid.unit);
    put(set, "about", grid.about);
    put(set, "spacing_mm", geometry::Vector3(shape.spacing / units::mm));
    put(set, "origin_mm", geometry::Vector3(shape.origin / units::mm));
  }
}

/// The whole file as HDF5 lays it out, in memory: the disk then sees one write.
std::string image_of(const SignalsFile& file) {
  const hdf5::Quiet quiet;
  const Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose, "access");
  const std::size_t step = std::size_t{1} << 22;
  ok(H5Pset_fapl_core(access, step, 0), "memory");
  const Handle out(H5Fcreate("signals", H5F_ACC_TRUNC, H5P_DEFAULT, access), H5Fclose, "file");
  put(out, "format", std::string(kFormat));
  put(out, "version", kVersion);
  put_all(out, file.attributes);
  for (const SignalRun& run : file.runs) write_run(out, run);
  ok(H5Fflush(out, H5F_SCOPE_GLOBAL), "flush");
  const ssize_t size = ok(H5Fget_file_image(out, nullptr, 0), "image");
  std::string image(static_cast<std::size_t>(size), '\0');
  ok(H5Fget_file_image(out, image.data(), image.size()), "image");
  return image;
}

void check_names(const SignalsFile& file) {
  const auto check = [](std::set<std::string>& taken, const std::string& kind,
                        const std::string& name) {
    if (name.empty() || name.find('/') != std::string::npos || name == "." ||
        !taken.insert(name).second)
      throw InvalidInput(
          {"signals." + kind, name, "must be a name, taken once, without a slash", "rename it"});
  };
  std::set<std::string> runs;
  for (const SignalRun& run : file.runs) {
    check(runs, "run", run.name);
    std::set<std::string> signals = {"events", "grids"};
    std::set<std::string> grids;
    for (const Signal& signal : run.signals) check(signals, run.name, signal.name);
    for (const SignalGrid& grid : run.grids) check(grids, run.name + ".grids", grid.name);
  }
}

// Reading.

std::vector<std::string> members(hid_t at) {
  H5G_info_t info{};
  ok(H5Gget_info(at, &info), "group");
  std::vector<std::string> names;
  for (hsize_t i = 0; i < info.nlinks; ++i) {
    const ssize_t length =
        ok(H5Lget_name_by_idx(at, ".", H5_INDEX_NAME, H5_ITER_INC, i, nullptr, 0, H5P_DEFAULT),
           "name");
    std::string name(static_cast<std::size_t>(length) + 1, '\0');
    ok(H5Lget_name_by_idx(at, ".", H5_INDEX_NAME, H5_ITER_INC, i, name.data(), name.size(),
                          H5P_DEFAULT),
       "name");
    name.pop_back();
    names.push_back(name);
  }
  return names;
}

std::string get_text(hid_t at, const std::string& name) {
  const Handle attribute(H5Aopen(at, name.c_str(), H5P_DEFAULT), H5Aclose, name);
  const Handle type(H5Aget_type(attribute), H5Tclose, name);
  if (H5Tis_variable_str(type) <= 0) throw hdf5::Failure(name + " is no text");
  char* text = nullptr;
  ok(H5Aread(attribute, string_type(), static_cast<void*>(&text)), name);
  std::string out = text != nullptr ? text : "";
  H5free_memory(text);
  return out;
}

geometry::Vector3 get_vector(hid_t at, const std::string& name) {
  const Handle attribute(H5Aopen(at, name.c_str(), H5P_DEFAULT), H5Aclose, name);
  const Handle space(H5Aget_space(attribute), H5Sclose, name);
  if (H5Sget_simple_extent_npoints(space) != 3) throw hdf5::Failure(name + " is no vector");
  geometry::Vector3 value;
  ok(H5Aread(attribute, H5T_NATIVE_DOUBLE, value.data()), name);
  return value;
}

SignalAttributes get_all(hid_t at) {
  SignalAttributes out;
  const int count = ok(H5Aget_num_attrs(at), "attributes");
  for (int i = 0; i < count; ++i) {
    const Handle attribute(H5Aopen_by_idx(at, ".", H5_INDEX_NAME, H5_ITER_INC,
                                          static_cast<hsize_t>(i), H5P_DEFAULT, H5P_DEFAULT),
                           H5Aclose, "attribute");
    char name[256] = {};
    ok(H5Aget_name(attribute, sizeof name, name), "attribute");
    const Handle type(H5Aget_type(attribute), H5Tclose, name);
    const H5T_class_t kind = H5Tget_class(type);
    if (kind == H5T_STRING) {
      out[name] = get_text(at, name);
    } else if (kind == H5T_INTEGER) {
      std::int64_t value = 0;
      ok(H5Aread(attribute, H5T_NATIVE_INT64, &value), name);
      out[name] = value;
    } else {
      double value = 0.0;
      ok(H5Aread(attribute, H5T_NATIVE_DOUBLE, &value), name);
      out[name] = value;
    }
  }
  return out;
}

std::vector<hsize_t> size_of(hid_t set, int rank) {
  const Handle space(H5Dget_space(set), H5Sclose, "size");
  if (H5Sget_simple_extent_ndims(space) != rank) throw hdf5::Failure("a data set of another shape");
  std::vector<hsize_t> size(static_cast<std::size_t>(rank));
  ok(H5Sget_simple_extent_dims(space, size.data(), nullptr), "size");
  return size;
}

Handle open_set(hid_t at, const std::string& name) {
  return {H5Dopen2(at, name.c_str(), H5P_DEFAULT), H5Dclose, name};
}

std::vector<double> get_series(hid_t set) {
  std::vector<double> values(size_of(set, 1)[0]);
  if (!values.empty())
    ok(H5Dread(set, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()), "series");
  return values;
}

std::vector<SignalEvent> get_events(hid_t run) {
  const Handle here(H5Gopen2(run, "events", H5P_DEFAULT), H5Gclose, "events");
  const std::vector<double> times = get_series(open_set(here, "time_s"));
  const Handle set = open_set(here, "text");
  if (size_of(set, 1)[0] != times.size()) throw hdf5::Failure("events of two lengths");
  std::vector<SignalEvent> events;
  if (times.empty()) return events;
  std::vector<char*> texts(times.size());
  const Handle type = string_type();
  ok(H5Dread(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, static_cast<void*>(texts.data())), "events");
  for (std::size_t i = 0; i < times.size(); ++i) events.push_back({times[i], texts[i]});
  const Handle space(H5Dget_space(set), H5Sclose, "events");
  H5Dvlen_reclaim(type, space, H5P_DEFAULT, static_cast<void*>(texts.data()));
  return events;
}

std::vector<SignalGrid> get_grids(hid_t run) {
  const Handle here(H5Gopen2(run, "grids", H5P_DEFAULT), H5Gclose, "grids");
  std::vector<SignalGrid> grids;
  for (const std::string& name : members(here)) {
    const Handle set = open_set(here, name);
    const std::vector<hsize_t> size = size_of(set, 3);
    geometry::GridShape shape;
    for (std::size_t i = 0; i < 3; ++i) shape.size[i] = static_cast<int>(size[2 - i]);
    shape.spacing = get_vector(set, "spacing_mm") * units::mm;
    shape.origin = get_vector(set, "origin_mm") * units::mm;
    SignalGrid grid{name, get_text(set, "unit"), geometry::VoxelGrid<float>(shape),
                    get_text(set, "about")};
    if (shape.count() > 0)
      ok(H5Dread(set, H5T_NATIVE_FLOAT, H5S_ALL, H5S_ALL, H5P_DEFAULT, grid.values.values().data()),
         name);
    grids.push_back(std::move(grid));
  }
  return grids;
}

}  // namespace

void write_signals(const SignalsFile& file, const std::filesystem::path& path) {
  check_names(file);
  std::string image;
  try {
    image = image_of(file);
  } catch (const hdf5::Failure& failure) {
    throw WorldError(fmt::format("{}: HDF5 fails at \"{}\"", path.string(), failure.what()));
  }
  write_text_file(path, image);
}

SignalsFile read_signals(const std::filesystem::path& path) {
  if (!std::filesystem::is_regular_file(path))
    throw InvalidInput({path.string(), "", "there is no such file", "check the name"});
  const hdf5::Quiet quiet;
  try {
    const Handle in(H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose, "file");
    SignalsFile file;
    file.attributes = get_all(Handle(H5Gopen2(in, "/", H5P_DEFAULT), H5Gclose, "root"));
    const auto format = file.attributes.extract("format");
    const auto version = file.attributes.extract("version");
    if (format.empty() || format.mapped() != SignalAttributes::mapped_type(kFormat) ||
        version.empty() || version.mapped() != SignalAttributes::mapped_type(kVersion))
      throw hdf5::Failure("format and version");
    for (const std::string& name : members(in)) {
      const Handle here(H5Gopen2(in, name.c_str(), H5P_DEFAULT), H5Gclose, name);
      SignalRun run;
      run.name = name;
      run.attributes = get_all(here);
      for (const std::string& member : members(here)) {
        if (member == "events" || member == "grids") continue;
        const Handle set = open_set(here, member);
        run.signals.push_back(
            {member, get_text(set, "unit"), get_series(set), get_text(set, "about")});
      }
      run.events = get_events(here);
      run.grids = get_grids(here);
      file.runs.push_back(std::move(run));
    }
    return file;
  } catch (const hdf5::Failure& failure) {
    throw InvalidInput({path.string(), failure.what(),
                        "is truncated or is no signals file of osteomill",
                        "give a signals.h5 of a run directory"});
  }
}

}  // namespace osteomill::io
