#pragma once

namespace flipflow {

// Makes the contact models of flipflow known to LIGGGHTS.  Every new instance of LIGGGHTS puts some
// models of its own into the same tables, in the place of ours: to be called after each.
void register_contact_models();

}  // namespace flipflow
