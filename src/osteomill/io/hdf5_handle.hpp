// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <hdf5.h>

#include <stdexcept>
#include <string>
#include <utility>

namespace osteomill::io::hdf5 {

/// A call of the HDF5 library failed; the callers say of which file.
class Failure : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// The result of a call, or Failure: every function of the library returns below 0 when it fails.
template <class T>
T ok(T result, const std::string& doing) {
  if (result < 0) throw Failure(doing);
  return result;
}

/// Owns one identifier of the library.
class Handle {
 public:
  using Close = herr_t (*)(hid_t);
  Handle(hid_t id, Close close, const std::string& doing) : id_(ok(id, doing)), close_(close) {}
  ~Handle() {
    if (id_ >= 0) close_(id_);
  }
  Handle(Handle&& other) noexcept : id_(std::exchange(other.id_, -1)), close_(other.close_) {}
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;
  operator hid_t() const { return id_; }

 private:
  hid_t id_;
  Close close_;
};

/// Keeps the library from printing its errors on standard error while it lives.
class Quiet {
 public:
  Quiet() {
    H5Eget_auto2(H5E_DEFAULT, &function_, &data_);
    H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
  }
  ~Quiet() { H5Eset_auto2(H5E_DEFAULT, function_, data_); }
  Quiet(const Quiet&) = delete;
  Quiet& operator=(const Quiet&) = delete;

 private:
  H5E_auto2_t function_ = nullptr;
  void* data_ = nullptr;
};

}  // namespace osteomill::io::hdf5
