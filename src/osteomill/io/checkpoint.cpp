// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/checkpoint.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <fstream>

#include "osteomill/base/archive.hpp"
#include "osteomill/base/error.hpp"
#include "osteomill/io/pending_file.hpp"

namespace osteomill::io {
namespace {

/// The number is another one when what lies in memory is.
constexpr std::string_view kForm = "osteomill checkpoint 2\n";

/// Fowler, Noll and Vo's hash, for what got lost on the way, not against anybody.
constexpr std::uint64_t kEmptyHash = 0xcbf29ce484222325;
std::uint64_t hash_of(std::string_view bytes, std::uint64_t hash = kEmptyHash) {
  for (const char c : bytes) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3;
  return hash;
}

[[noreturn]] void refuse(const std::filesystem::path& file, const std::string& why) {
  throw InvalidInput(Fault{file.string(), why, "must be the checkpoint of this run",
                           "run without --resume, or with the case and program that wrote it"});
}

}  // namespace

CheckpointedPlant::CheckpointedPlant(control::Plant& inner, simulate::Milling& milling,
                                     simulate::StockWorkpiece& workpiece, const std::string& name,
                                     const std::string& identity, const CheckpointOptions& options)
    : inner_(inner),
      milling_(milling),
      workpiece_(workpiece),
      options_(options),
      file_(options.folder / (name + ".checkpoint")),
      head_(fmt::format("{}{}\ncase {:016x}, bone {}\n", kForm, options.program, hash_of(identity),
                        workpiece.stock().initial_units())) {
  if (options_.resume && std::filesystem::exists(file_)) load();
  saved_at_ = options_.clock();
}

void CheckpointedPlant::load() {
  std::ifstream stream(file_, std::ios::binary);
  if (!stream) refuse(file_, std::strerror(errno));
  // The first three lines, to be compared by eye.
  std::string head;
  for (std::string line; head.size() < head_.size() && std::getline(stream, line);)
    head += line + "\n";
  if (!head.starts_with(kForm.substr(0, kForm.find_last_of(' ')))) refuse(file_, "no checkpoint");
  if (head != head_)
    refuse(file_, fmt::format("of another run: \"{}\"",
                              head.substr(0, std::min<std::size_t>(head.size() - 1, 300))));
  const std::uint64_t size = std::filesystem::file_size(file_);
  if (size < head.size() + sizeof(std::uint64_t)) refuse(file_, "cut short");
  const std::uint64_t body = size - head.size() - sizeof(std::uint64_t);

  // What is broken is found before anything is overwritten by it.
  std::uint64_t hash = hash_of(head), sum = 0;
  std::vector<char> chunk(std::size_t{1} << 20);
  for (std::uint64_t left = body; left > 0 && stream;) {
    const auto part = static_cast<std::size_t>(std::min<std::uint64_t>(left, chunk.size()));
    stream.read(chunk.data(), static_cast<std::streamsize>(part));
    hash = hash_of({chunk.data(), part}, hash);
    left -= part;
  }
  stream.read(reinterpret_cast<char*>(&sum), sizeof sum);
  if (!stream || sum != hash) refuse(file_, "broken: its check sum is wrong");

  stream.seekg(static_cast<std::streamoff>(head.size()));
  std::uint64_t taken = 0;
  Archive loader = Archive::loading(
      [&](void* at, std::size_t bytes) {
        taken += bytes;
        if (taken > body) refuse(file_, "of another form");
        stream.read(static_cast<char*>(at), static_cast<std::streamsize>(bytes));
      },
      body);
  loader(answers_, commands_, milling_, workpiece_);
  if (!stream || taken != body || answers_.size() != commands_.size() + 1)
    refuse(file_, "of another form");
  resumed_ = commands_.size();
}

void CheckpointedPlant::save() {
  std::error_code ignored;  // writing says what is wrong with the folder
  std::filesystem::create_directories(options_.folder, ignored);
  try {
    PendingFile pending(file_);
    std::ofstream stream(pending.path(), std::ios::binary);
    std::uint64_t hash = kEmptyHash;
    const auto write = [&](const void* from, std::size_t size) {
      hash = hash_of({static_cast<const char*>(from), size}, hash);
      stream.write(static_cast<const char*>(from), static_cast<std::streamsize>(size));
    };
    write(head_.data(), head_.size());
    Archive::saving(write)(answers_, commands_, milling_, workpiece_);
    const std::uint64_t sum = hash;
    stream.write(reinterpret_cast<const char*>(&sum), sizeof sum);
    stream.close();
    if (!stream)
      throw WorldError(
          fmt::format("{}: cannot be written: {}; check the rights and the space on the disk",
                      file_.string(), std::strerror(errno)));
    pending.commit();
  } catch (const WorldError& error) {
    throw WorldError(fmt::format(
        "{}; the run was stopped at {:.2f} s of its time{}: make room and go on with --resume",
        error.what(), answers_.back().time,
        std::filesystem::exists(file_) ? ", the checkpoint before is whole" : ""));
  }
  saved_at_ = options_.clock();
}

control::Observation CheckpointedPlant::start() {
  if (answers_.empty()) answers_.push_back(inner_.start());
  at_ = 1;
  return answers_.front();
}

control::Observation CheckpointedPlant::advance(const control::FeedCommand& command) {
  if (at_ < answers_.size()) {
    if (std::bit_cast<std::uint64_t>(commands_[at_ - 1]) !=
        std::bit_cast<std::uint64_t>(command.feed))
      refuse(file_, fmt::format("of a run that was commanded otherwise at {:.2f} s",
                                answers_[at_ - 1].time));
    return answers_[at_++];
  }
  answers_.push_back(inner_.advance(command));
  commands_.push_back(command.feed);
  ++at_;
  if (options_.clock() - saved_at_ >= options_.every) save();
  return answers_.back();
}

}  // namespace osteomill::io
