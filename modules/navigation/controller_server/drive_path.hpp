#pragma once
// Makes a path drivable from where a body is. Pure; any thread. Metres, radians, the frame of the
// map.

#include "musher/navigation/pose.hpp"

namespace musher::navigation {

// The rest of `path` from its point nearest to `from` on, at most `join_m` away, with `from` before
// it. Empty: the path is farther away.
Path JoinedPath(const Path& path, const Pose& from, double join_m, bool flat);

// The same path for a body that looks where it drives: it turns on the spot at the begin, at the
// end and at corners of more than 20 degrees, and within 0.2 m of smaller ones. The yaw of the
// first and the last pose stay. Other yaws of `path` are not used. `moves`: the body is on its way,
// so that it turns on the spot at the begin only for more than 20 degrees.
Path LookingAhead(const Path& path, bool moves);

}  // namespace musher::navigation
