// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <matio.h>

#include <algorithm>
#include <cstdint>
#include <fstream>
#include <memory>

#include "osteomill/base/error.hpp"
#include "osteomill/io/force_record_table.hpp"
#include "osteomill/io/hdf5_handle.hpp"

namespace osteomill::io {
namespace {

struct CloseFile {
  void operator()(mat_t* file) const { Mat_Close(file); }
};
struct FreeVariable {
  void operator()(matvar_t* variable) const { Mat_VarFree(variable); }
};
using File = std::unique_ptr<mat_t, CloseFile>;
using Variable = std::unique_ptr<matvar_t, FreeVariable>;

constexpr std::size_t kWidest = 64;  // columns of a matrix of channels

template <class T>
Eigen::MatrixXd matrix_of(const matvar_t& variable) {
  const auto rows = static_cast<Eigen::Index>(variable.dims[0]);
  const auto columns = static_cast<Eigen::Index>(variable.dims[1]);
  using Values = Eigen::Matrix<T, Eigen::Dynamic, Eigen::Dynamic>;
  return Eigen::Map<const Values>(static_cast<const T*>(variable.data), rows, columns)
      .template cast<double>();
}

/// The numbers of a variable; empty for one that holds none, or is complex, or no table.
Eigen::MatrixXd numbers_of(const matvar_t& variable) {
  if (variable.rank != 2 || variable.data == nullptr || variable.isComplex != 0) return {};
  const std::size_t least = std::min(variable.dims[0], variable.dims[1]);
  if (least == 0 || least > kWidest) return {};
  switch (variable.class_type) {
    case MAT_C_DOUBLE:
      return matrix_of<double>(variable);
    case MAT_C_SINGLE:
      return matrix_of<float>(variable);
    case MAT_C_INT8:
      return matrix_of<mat_int8_t>(variable);
    case MAT_C_UINT8:
      return matrix_of<mat_uint8_t>(variable);
    case MAT_C_INT16:
      return matrix_of<mat_int16_t>(variable);
    case MAT_C_UINT16:
      return matrix_of<mat_uint16_t>(variable);
    case MAT_C_INT32:
      return matrix_of<mat_int32_t>(variable);
    case MAT_C_UINT32:
      return matrix_of<mat_uint32_t>(variable);
    default:
      return {};
  }
}

void take(matvar_t& variable, const std::string& name, RecordTable& table) {
  if (variable.class_type == MAT_C_STRUCT) {
    const bool one = variable.rank == 2 && variable.dims[0] == 1 && variable.dims[1] == 1;
    char* const* fields = Mat_VarGetStructFieldnames(&variable);
    const unsigned count = Mat_VarGetNumberOfFields(&variable);
    for (unsigned k = 0; one && fields != nullptr && k < count; ++k) {
      if (matvar_t* field = Mat_VarGetStructFieldByIndex(&variable, k, 0))
        take(*field, name + "." + fields[k], table);
    }
    return;
  }
  const Eigen::MatrixXd values = numbers_of(variable);
  if (values.size() == 0) return;
  if (values.size() == 1) {
    if (names_a_rate(name)) table.rate = values(0, 0);
    return;
  }
  std::string plain, unit;
  split_unit(name, plain, unit);
  add_channels(table, plain, unit, values);
}

/// Whether the last element of a version 5 file ends before the file does: matio leaves a variable
/// that is cut off out without a word. Elements begin behind 128 bytes of header with type and
/// size.
bool is_whole(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  char mark[2] = {};
  stream.seekg(126);
  stream.read(mark, 2);
  const bool swapped = mark[0] == 'M';  // "IM" where the bytes are in this machine's order
  std::uint64_t at = 128;
  const std::uint64_t end = std::filesystem::file_size(file);
  while (at + 8 <= end) {
    std::uint32_t tag[2] = {};
    stream.seekg(static_cast<std::streamoff>(at));
    if (!stream.read(reinterpret_cast<char*>(tag), sizeof tag)) return false;
    at += 8u + (swapped ? __builtin_bswap32(tag[1]) : tag[1]);
  }
  return at == end;
}

}  // namespace

RecordTable read_matlab_record(const std::filesystem::path& file) {
  const hdf5::Quiet quiet;  // version 7.3 is HDF5 inside
  const InvalidInput unreadable(
      {file.string(), "", "cannot be read as a MATLAB file",
       "the file may be cut off, or of another format (record.kind); save "
       "it again in MATLAB"});
  const File in(Mat_Open(file.c_str(), MAT_ACC_RDONLY));
  if (!in) throw unreadable;
  RecordTable table;
  table.file = file.filename().string();
  const auto version = Mat_GetVersion(in.get());
  table.format = version == MAT_FT_MAT73 ? "MATLAB 7.3" : "MATLAB 5";
  if (version == MAT_FT_MAT5 && !is_whole(file)) throw unreadable;
  std::size_t listed = 0;
  if (Mat_GetDir(in.get(), &listed) == nullptr || listed == 0) throw unreadable;
  Mat_Rewind(in.get());
  std::size_t read = 0;
  while (const Variable variable{Mat_VarReadNext(in.get())}) {
    ++read;
    if (variable->name != nullptr) take(*variable, variable->name, table);
  }
  if (read < listed) throw unreadable;
  return table;
}

}  // namespace osteomill::io
