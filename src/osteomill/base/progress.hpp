// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <string_view>

namespace osteomill {

/// How long work reports and how it is asked to stop. Called often and cheaply, with what is being
/// done and the share done (0...1). Returns false when the work should stop at the next clean point
/// and keep what is done. An empty function neither reports nor stops.
using Progress = std::function<bool(std::string_view doing, double share)>;

/// Calls it when there is one; true means go on.
inline bool go_on(const Progress& progress, std::string_view doing, double share) {
  return !progress || progress(doing, share);
}

}  // namespace osteomill
