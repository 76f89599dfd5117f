// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>

namespace osteomill::io {

/// InvalidInput when a PLY file is shorter than its header promises, or has no whole header. To be
/// asked before assimp reads it, which never comes back from the end of a PLY file that was cut
/// short.
void check_ply_is_whole(const std::filesystem::path& path);

}  // namespace osteomill::io
