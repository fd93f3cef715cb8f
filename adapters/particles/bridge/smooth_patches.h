#pragma once

#include <vector>

#include "surface_path.h"
#include "triangle.h"

namespace flipflow {

// A place of the surface within reach of a particle, or (after `share_smooth_patches`) a contact.
struct Touch {
  int triangle;
  ClosestPoint at;
  Vec3 away;          // from the closest point to the particle's centre
  double distance2;
  int record = 0;      // which of the particle's records of contacts is this one's
  double depth_m = 0;  // the measure by which contacts are compared: overlap, or more with adhesion
  double weight = 1;  // share of the contact force that acts, 0 ... 1
  Vec3 turning = {0, 0, 0};  // m^1.5: force of the turning normal for an energy of depth^2.5
};

// Keeps the places where the distance to the surface is smallest in their surroundings, nearest
// first.  Of a surface that repeats itself, `triangles` have one number for points that are the same
// place.
void keep_minima(std::vector<Touch> &touches, const std::vector<Triangle> &triangles);

// Shares the force between places that are one contact with a smooth surface
// (docs/theory/particle_surface_contact.md): weights are the derivatives of a common potential of
// the contacts' elastic energies, which go with depth^2.5.  Contacts without weight are left out.
void share_smooth_patches(std::vector<Touch> &touches, const SurfacePath &surface,
                          const std::vector<Triangle> &triangles);

}  // namespace flipflow
