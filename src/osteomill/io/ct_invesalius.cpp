// SPDX-License-Identifier: BSD-3-Clause
#include <archive.h>
#include <archive_entry.h>
#include <fmt/format.h>
#include <plist/plist.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <memory>
#include <optional>

#include "osteomill/base/error.hpp"
#include "osteomill/io/ct_formats.hpp"

namespace osteomill::io {
namespace {

struct FreeArchive {
  void operator()(archive* a) const { archive_read_free(a); }
};
struct FreePlist {
  void operator()(plist_t p) const { plist_free(p); }
};

[[noreturn]] void refuse(const std::filesystem::path& path, const std::string& field,
                         const std::string& value, const std::string& rule) {
  throw InvalidInput({field.empty() ? path.string() : path.string() + ": " + field, value, rule,
                      "give a project that InVesalius 3 saved"});
}

/// The bytes of the member of that name in any folder of the archive, as many as it says it has.
std::string member(const std::filesystem::path& path, const std::string& name) {
  const std::unique_ptr<archive, FreeArchive> tar(archive_read_new());
  archive_read_support_filter_all(tar.get());
  archive_read_support_format_tar(tar.get());
  const auto complaint = [&] {
    const char* text = archive_error_string(tar.get());
    return fmt::format("is no InVesalius project or is truncated: {}",
                       text != nullptr ? text : "unreadable archive");
  };
  if (archive_read_open_filename(tar.get(), path.c_str(), 1 << 16) != ARCHIVE_OK)
    refuse(path, "", "", complaint());
  archive_entry* entry = nullptr;
  int status = ARCHIVE_OK;
  while ((status = archive_read_next_header(tar.get(), &entry)) == ARCHIVE_OK) {
    const char* full = archive_entry_pathname(entry);
    if (full == nullptr || std::filesystem::path(full).filename() != name) continue;
    const std::int64_t size = archive_entry_size(entry);
    // 64 GB is far beyond any scan; a broken header may claim anything.
    if (size < 0 || size > (std::int64_t{1} << 36))
      refuse(path, name, fmt::format("{} bytes", size), "is not a plausible size");
    std::string bytes;
    constexpr std::size_t kPiece = 1 << 22;
    while (bytes.size() < static_cast<std::size_t>(size)) {
      const std::size_t at = bytes.size();
      bytes.resize(std::min(at + kPiece, static_cast<std::size_t>(size)));
      const la_ssize_t got = archive_read_data(tar.get(), bytes.data() + at, bytes.size() - at);
      if (got <= 0) refuse(path, name, fmt::format("{} of {} bytes", at, size), complaint());
      bytes.resize(at + static_cast<std::size_t>(got));
    }
    return bytes;
  }
  if (status != ARCHIVE_EOF) refuse(path, "", "", complaint());
  refuse(path, name, "", "is not in the project");
}

/// A node of the property list, and its name for messages.
class Node {
 public:
  Node(const std::filesystem::path& path, plist_t node, std::string name)
      : path_(path), node_(node), name_(std::move(name)) {}

  Node operator[](const char* key) const {
    plist_t item = is(PLIST_DICT) ? plist_dict_get_item(node_, key) : nullptr;
    const std::string name = name_ + "." + key;
    if (item == nullptr) refuse(path_, name, "", "is missing");
    return {path_, item, name};
  }
  Node operator[](std::uint32_t i) const {
    if (!is(PLIST_ARRAY) || plist_array_get_size(node_) != 3)
      refuse(path_, name_, "", "must be three numbers");
    return {path_, plist_array_get_item(node_, i), fmt::format("{}[{}]", name_, i)};
  }
  double number() const {
    double real = 0.0;
    std::uint64_t whole = 0;
    if (is(PLIST_REAL))
      plist_get_real_val(node_, &real);
    else if (is(PLIST_UINT))
      plist_get_uint_val(node_, &whole), real = static_cast<double>(whole);
    else
      refuse(path_, name_, "", "must be a number");
    return real;
  }
  std::string text() const {
    if (!is(PLIST_STRING)) refuse(path_, name_, "", "must be a text");
    std::uint64_t length = 0;
    const char* start = plist_get_string_ptr(node_, &length);
    return {start, length};
  }
  const std::string& name() const { return name_; }

 private:
  bool is(plist_type type) const { return node_ != nullptr && plist_get_node_type(node_) == type; }

  const std::filesystem::path& path_;
  plist_t node_;
  std::string name_;
};

}  // namespace

/// A project is a tar, mostly gzipped, with main.plist and the voxels as a bare array. The array
/// runs slices, rows, columns; rows run from back to front, and the surfaces that InVesalius saves
/// beside it stand at (column, -row, slice) times the spacing: that right-handed frame is P here.
/// InVesalius does not keep the patient position of the scan.
RawVolume read_invesalius(const std::filesystem::path& path) {
  const std::string text = member(path, "main.plist");
  plist_t parsed = nullptr;
  plist_from_memory(text.data(), static_cast<std::uint32_t>(text.size()), &parsed);
  const std::unique_ptr<void, FreePlist> owner(parsed);
  if (parsed == nullptr) refuse(path, "main.plist", "", "is no property list");
  const Node root(path, parsed, "main.plist");

  if (root["modality"].text() != "CT")
    refuse(path, root["modality"].name(), root["modality"].text(), "must be CT");
  const Node matrix = root["matrix"];
  if (matrix["dtype"].text() != "int16")
    refuse(path, matrix["dtype"].name(), matrix["dtype"].text(), "must be int16");
  RawVolume raw;
  double count = 1.0;
  for (std::uint32_t i = 0; i < 3; ++i) {
    const Node size = matrix["shape"][2 - i];
    if (!(size.number() >= 1.0 && size.number() <= 16384.0))
      refuse(path, size.name(), fmt::format("{}", size.number()), "must be 1 … 16384");
    raw.size[i] = static_cast<int>(size.number());
    count *= raw.size[i];
    raw.spacing_mm[i] = root["spacing"][i].number();
  }
  const std::string file = matrix["filename"].text();
  const std::string bytes = member(path, file);
  if (static_cast<double>(bytes.size()) != 2.0 * count)
    refuse(path, file, fmt::format("{} bytes", bytes.size()),
           fmt::format("must hold {:.0f} bytes, two a voxel", 2.0 * count));
  std::vector<std::int16_t> voxels(bytes.size() / 2);
  std::memcpy(voxels.data(), bytes.data(), bytes.size());
  raw.values.assign(voxels.begin(), voxels.end());
  raw.direction = Eigen::Vector3d(1.0, -1.0, 1.0).asDiagonal();
  raw.origin_mm = Eigen::Vector3d::Zero();
  raw.description =
      fmt::format("InVesalius project {}, \"{}\"", path.filename().string(), root["name"].text());
  raw.remarks.push_back(
      "an InVesalius project keeps no patient position: the patient frame is that of its surfaces, "
      "taken as x left, y back, z head");
  return raw;
}

}  // namespace osteomill::io
