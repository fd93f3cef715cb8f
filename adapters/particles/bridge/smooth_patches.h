#pragma once

#include <vector>

#include "triangle.h"
#include "triangle_grid.h"

namespace flipflow {

// A triangle within reach of a particle, or (after `one_per_smooth_patch`) a contact.
struct Touch {
  int triangle;
  ClosestPoint at;
  Vec3 away;          // from the closest point to the particle's centre
  double distance2;
  double weight;      // share of the contact force that acts, 0 ... 1
};

// Keeps one contact per smooth patch of the surface (docs/theory/particle_surface_contact.md):
// only places where the distance to the surface is smallest in their surroundings, and of those
// whose normals differ by less than 15 degrees only the deepest; from 15 to 45 degrees the
// shallower one fades in.
void one_per_smooth_patch(std::vector<Touch> &touches, const std::vector<Triangle> &triangles);

}  // namespace flipflow
