// What this build is.
#pragma once

namespace parallax {

// Part of every result's key: raise it whenever equal inputs would give other bytes.
inline constexpr char kGeneratorVersion[] = "17";
// Of the programs, for people.
inline constexpr char kProgramVersion[] = PARALLAX_VERSION;

}  // namespace parallax
