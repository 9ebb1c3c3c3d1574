// The floor plan of a house: rectangular rooms, placed by annealing so that they share walls with
// the rooms to which they belong. Private to worker/layout. Pure.
//
// Invariants of a plan: cells of one storey do not overlap and lie apart by nothing or by at least
// kLeastGap_m; cell 0 never moves.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/base/rng.h"

namespace parallax {

// A room, with half of each shared wall around it.
struct Cell {
  std::string kind;
  int storey = 0;
  bool both_storeys = false;    // The stairs: its storey and the one above.
  double x = 0, y = 0;          // Corner with the smaller coordinates.
  double width = 0, depth = 0;  // Along x and y.
  double goal_m2 = 0;           // Wanted area.
  double least_m = 0;           // Least width and depth, metres.
  bool fixed_size = false;
  double landing_m = 0;  // Stairs: doors open within this distance of wall 0 only.

  double Right() const { return x + width; }
  double Top() const { return y + depth; }
};

// The stretch of wall that two cells share: walls as Opening.wall, [low, high] in the world
// coordinate along it.
struct Contact {
  int wall_a = 0, wall_b = 0;
  double low = 0, high = 0;
};
// Returns the contact of two cells; nothing if they do not touch.
std::optional<Contact> TouchOf(const Cell& a, const Cell& b);
// Returns the part of the contact where a door may be; nothing where it is too short.
std::optional<Contact> DoorStretch(const Cell& a, const Cell& b);

// Returns the cost of a door between rooms of these two kinds in a house: 0 where people want one,
// more where they do not.
double LinkCost(const std::string& a, const std::string& b);

// The doors that connect every room to the main one at the least cost, as pairs of cells.
struct Links {
  std::vector<std::pair<int, int>> pairs;
  double cost = 0;
  int unreached = 0;
};
// Finds them by Prim's algorithm from the main room.
Links CheapestLinks(const std::vector<Cell>& cells);

// The best plan found, with the course of its annealing.
struct FloorPlan {
  std::vector<Cell> cells;
  Links links;
  double initial_loss = 0;
  std::vector<double> loss_curve;  // Thinned.
  int steps = 0, accepted = 0;
};

// Returns the terms of the loss, in this order: unreached, links, waste, light, areas, shapes,
// support.
std::vector<std::pair<std::string, double>> PlanTerms(const std::vector<Cell>& cells,
                                                      const Links& links);

// Places the cells, which have kinds, storeys and goals; cell 0 has its place too and keeps it.
FloorPlan PlaceCells(std::vector<Cell> cells, int steps, Rng rng);

}  // namespace parallax
