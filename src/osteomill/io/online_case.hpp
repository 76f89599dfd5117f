// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "osteomill/identify/online_track.hpp"
#include "osteomill/io/cutting_section.hpp"

/// The case of `osteomill identify online`: a recording of forces or powers, and the bone that
/// strength is measured against.
namespace osteomill::io {

struct CaseRun;
class Section;

struct OnlineCase {
  std::string source;  ///< name of the recording or table
  std::vector<identify::OnlinePeriod> periods;
  std::optional<BoneCase> bone;  ///< none: the reference is a gain
  identify::FeedResponse response{1.0};
  identify::TrackOptions options;
  std::vector<std::string> warnings;
  nlohmann::ordered_json expanded;
};

/// The keys, for the schema.
void bind_online(Section& section);

/// Throws InvalidInput with all faults of the case, and those of the recording.
OnlineCase read_online_case(const CaseRun& run);

/// The JSON document: docs/guide/identify-online.md.
nlohmann::ordered_json online_document(const OnlineCase& input, const identify::OnlineTrack& track);

/// The reference bone with the strength that was found, as a catalogue entry (TOML). Throws
/// InvalidInput where the reference is a gain or no period was in bone.
std::string patient_entry(const OnlineCase& input, const identify::OnlineTrack& track);

}  // namespace osteomill::io
