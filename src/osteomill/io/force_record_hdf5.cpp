// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <optional>

#include "osteomill/base/error.hpp"
#include "osteomill/io/force_record_table.hpp"
#include "osteomill/io/hdf5_handle.hpp"

namespace osteomill::io {
namespace {

using hdf5::Handle;
using hdf5::ok;

constexpr hsize_t kWidest = 64;  // columns of a matrix of channels

/// An attribute that is a text, fixed or of variable length; nothing when it is not there.
std::optional<std::string> text_attribute(hid_t at, const char* name) {
  if (H5Aexists(at, name) <= 0) return {};
  const Handle attribute(H5Aopen(at, name, H5P_DEFAULT), H5Aclose, name);
  const Handle type(H5Aget_type(attribute), H5Tclose, name);
  if (H5Tget_class(type) != H5T_STRING) return {};
  const Handle space(H5Aget_space(attribute), H5Sclose, name);
  if (H5Sget_simple_extent_npoints(space) != 1) return {};
  if (H5Tis_variable_str(type) > 0) {
    char* text = nullptr;
    ok(H5Aread(attribute, type, static_cast<void*>(&text)), name);
    std::string out = text != nullptr ? text : "";
    H5free_memory(text);
    return out;
  }
  std::string out(H5Tget_size(type), '\0');
  ok(H5Aread(attribute, type, out.data()), name);
  out.resize(std::min(out.size(), out.find('\0')));
  return out;
}

std::optional<double> rate_attribute(hid_t at) {
  for (const char* name :
       {"rate_hz", "sampling_rate_hz", "sampling_rate", "sample_rate", "sample_rate_hz", "fs"}) {
    if (H5Aexists(at, name) <= 0) continue;
    const Handle attribute(H5Aopen(at, name, H5P_DEFAULT), H5Aclose, name);
    const Handle space(H5Aget_space(attribute), H5Sclose, name);
    const Handle type(H5Aget_type(attribute), H5Tclose, name);
    const H5T_class_t kind = H5Tget_class(type);
    if (H5Sget_simple_extent_npoints(space) != 1 || (kind != H5T_FLOAT && kind != H5T_INTEGER))
      continue;
    double value = 0.0;
    ok(H5Aread(attribute, H5T_NATIVE_DOUBLE, &value), name);
    return value;
  }
  return {};
}

void read_set(hid_t file, const std::string& name, RecordTable& table) {
  const Handle set(H5Dopen2(file, name.c_str(), H5P_DEFAULT), H5Dclose, name);
  const Handle type(H5Dget_type(set), H5Tclose, name);
  const H5T_class_t kind = H5Tget_class(type);
  if (kind != H5T_FLOAT && kind != H5T_INTEGER) return;
  const Handle space(H5Dget_space(set), H5Sclose, name);
  const int rank = H5Sget_simple_extent_ndims(space);
  if (rank > 2) return;
  hsize_t size[2] = {1, 1};
  ok(H5Sget_simple_extent_dims(space, size, nullptr), name);
  if (size[0] == 0 || size[1] == 0 || std::min(size[0], size[1]) > kWidest) return;
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> values(
      static_cast<Eigen::Index>(size[0]), static_cast<Eigen::Index>(size[1]));
  ok(H5Dread(set, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()), name);
  if (values.size() == 1) {
    if (names_a_rate(name)) table.rate = values(0, 0);
    return;
  }
  std::string plain, unit;
  split_unit(name, plain, unit);
  auto stated = text_attribute(set, "unit");
  if (!stated) stated = text_attribute(set, "units");
  if (!table.rate) table.rate = rate_attribute(set);
  add_channels(table, stated ? name : plain, stated.value_or(unit), values);
}

/// Names of all data sets of the file, groups before the slash.
std::vector<std::string> data_sets(hid_t file, std::vector<std::string>& groups) {
  struct Found {
    std::vector<std::string> sets;
    std::vector<std::string>* groups;
  } found{{}, &groups};
  const auto visit = [](hid_t, const char* name, const H5O_info_t* info, void* data) -> herr_t {
    auto& out = *static_cast<Found*>(data);
    if (info->type == H5O_TYPE_DATASET) out.sets.emplace_back(name);
    if (info->type == H5O_TYPE_GROUP) out.groups->emplace_back(name);
    return 0;
  };
  ok(H5Ovisit2(file, H5_INDEX_NAME, H5_ITER_INC, visit, &found, H5O_INFO_BASIC), "file");
  return found.sets;
}

}  // namespace

RecordTable read_hdf5_record(const std::filesystem::path& file) {
  const hdf5::Quiet quiet;
  RecordTable table;
  table.file = file.filename().string();
  table.format = "HDF5";
  try {
    const Handle in(H5Fopen(file.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose, "opening it");
    std::vector<std::string> groups;
    const std::vector<std::string> sets = data_sets(in, groups);
    for (const std::string& name : groups) {
      if (table.rate) break;
      const Handle group(H5Gopen2(in, name.c_str(), H5P_DEFAULT), H5Gclose, name);
      table.rate = rate_attribute(group);
    }
    for (const std::string& name : sets) read_set(in, name, table);
  } catch (const hdf5::Failure& failure) {
    throw InvalidInput({file.string(), "",
                        fmt::format("cannot be read as HDF5: {} fails", failure.what()),
                        "the file may be cut off, or of another format (record.kind)"});
  }
  return table;
}

}  // namespace osteomill::io
