#pragma once

#include <vector>

#include "surface_path.h"
#include "triangle.h"
#include "triangle_grid.h"

namespace flipflow {

// A triangle within reach of a particle, or (after `share_smooth_patches`) a contact.
struct Touch {
  int triangle;
  ClosestPoint at;
  Vec3 away;          // from the closest point to the particle's centre
  double distance2;
  double weight = 1;  // share of the contact force that acts, 0 ... 1
  Vec3 turning = {0, 0, 0};  // m^1.5: force of the turning normal for an energy of overlap^2.5
};

// Triangles by the numbers of their points; `joined` has one number for points that are the same
// place on a surface that repeats itself.
struct Topology {
  const std::vector<Triangle> &triangles, &joined;
};

// Keeps the places where the distance to the surface is smallest in their surroundings, nearest
// first, and shares the force between those that are one contact with a smooth surface
// (docs/theory/particle_surface_contact.md): weights are the derivatives of a common potential of
// the contacts' elastic energies.  Contacts without weight are left out.
void share_smooth_patches(std::vector<Touch> &touches, const SurfacePath &surface,
                          const Topology &topology, double radius_m);

}  // namespace flipflow
