// How fine the kernel divides curved surfaces. The makers ask here; a scope says it for all shapes
// that its thread makes meanwhile.
#pragma once

namespace parallax::kernel {

// While it lives, pieces made by this thread aim at `target_edge_m`; 0 changes nothing. Scopes
// nest.
class DetailScope {
 public:
  explicit DetailScope(float target_edge_m);
  ~DetailScope();
  DetailScope(const DetailScope&) = delete;
  DetailScope& operator=(const DetailScope&) = delete;

 private:
  float before_;
};

// The edge length that the current scope asks for, metres; 0: none.
float TargetEdge();

// The pieces into which a length is cut: `usual`, or what the scope's target asks for, at least
// `least` and at most four times the usual.
int DetailedPieces(int usual, float length_m, int least = 2);

// The same for a full circle: a multiple of four, at least eight.
int DetailedSegments(int usual, float radius_m);

// The longest edge of a cloth's grid: `usual_m` or the scope's target.
float DetailedEdge(float usual_m);

}  // namespace parallax::kernel
