// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/checkpoint.hpp"

#include <fmt/format.h>

#include <bit>
#include <cstdint>

#include "osteomill/base/archive.hpp"
#include "osteomill/base/error.hpp"
#include "osteomill/io/text_file.hpp"

namespace osteomill::io {
namespace {

/// The number is another one when what lies in memory is.
constexpr std::string_view kForm = "osteomill checkpoint 2\n";

/// Fowler, Noll and Vo's hash, for what got lost on the way, not against anybody.
std::uint64_t hash_of(std::string_view bytes) {
  std::uint64_t hash = 0xcbf29ce484222325;
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
  const std::string text = read_text_file(file_);
  if (!text.starts_with(kForm.substr(0, kForm.find_last_of(' ')))) refuse(file_, "no checkpoint");
  if (!text.starts_with(head_)) {
    // The first three lines, to be compared by eye.
    std::size_t end = 0;
    for (int line = 0; line < 3 && end != std::string::npos; ++line) end = text.find('\n', end + 1);
    refuse(file_,
           fmt::format("of another run: \"{}\"", text.substr(0, std::min<std::size_t>(end, 300))));
  }
  if (text.size() < head_.size() + sizeof(std::uint64_t)) refuse(file_, "cut short");
  const std::string_view body =
      std::string_view(text).substr(0, text.size() - sizeof(std::uint64_t));
  std::uint64_t sum = 0;
  std::memcpy(&sum, text.data() + body.size(), sizeof sum);
  if (sum != hash_of(body)) refuse(file_, "broken: its check sum is wrong");
  Loader loader(body.substr(head_.size()));
  loader(answers_, commands_, milling_, workpiece_);
  if (!loader.at_end() || answers_.size() != commands_.size() + 1) refuse(file_, "of another form");
  resumed_ = commands_.size();
}

void CheckpointedPlant::save() {
  Saver saver;
  saver(answers_, commands_, milling_, workpiece_);
  std::string text = head_ + saver.bytes();
  const std::uint64_t sum = hash_of(text);
  text.append(reinterpret_cast<const char*>(&sum), sizeof sum);
  std::error_code ignored;  // writing says what is wrong with the folder
  std::filesystem::create_directories(options_.folder, ignored);
  try {
    write_text_file(file_, text);
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
