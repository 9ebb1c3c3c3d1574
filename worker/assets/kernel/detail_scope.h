// How finely the kernel divides curved surfaces. Makers ask here; a scope sets it for all shapes
// that its thread makes.
#pragma once

namespace parallax::kernel {

// While it lives, pieces made by this thread are about `target_edge_m` long; 0 changes nothing.
// Scopes nest.
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

// Number of pieces for a length: `usual`, or the number for the scope's target, at least `least`
// and at most four times the usual.
int DetailedPieces(int usual, float length_m, int least = 2);

// The same for a full circle: a multiple of four, at least eight.
int DetailedSegments(int usual, float radius_m);

// The longest edge of a cloth's grid: `usual_m` or the scope's target.
float DetailedEdge(float usual_m);

}  // namespace parallax::kernel
