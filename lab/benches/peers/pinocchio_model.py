"""Writes Pinocchio's model of a description as text, for cpp/model.hpp.

A C++ program built for this machine's instructions cannot share Eigen's types with the wheel's
library, which was built for any machine, so it takes the model from here.

    pinocchio_model.py DESCRIPTION fixed|floating OUTPUT [KIND:LINK...]
"""

import sys

import pinocchio


def lines(model):
    """A line a joint: name, parent, type, axis, placement by rows, mass, centre of mass, inertia."""
    for joint in range(1, model.njoints):
        kind = model.joints[joint].shortname().removeprefix("JointModel")
        unaligned = kind.endswith("Unaligned")
        axis = model.joints[joint].extract().axis if unaligned else (0, 0, 0)
        placement, inertia = model.jointPlacements[joint], model.inertias[joint]
        symmetric = [inertia.inertia[i, j] for i in range(3) for j in range(3)]
        numbers = [*axis, *placement.rotation.flatten(), *placement.translation]
        numbers += [inertia.mass, *inertia.lever, *symmetric]
        yield f"{model.names[joint]} {model.parents[joint]} {kind} " + " ".join(
            repr(float(number)) for number in numbers
        )


def placed(model, contact):
    """A line a contact: its kind, the joint that carries it, its placement on the joint."""
    kind, link = contact.split(":")
    frame = model.frames[model.getFrameId(link, pinocchio.FrameType.BODY)]
    numbers = [*frame.placement.rotation.flatten(), *frame.placement.translation]
    return f"contact {kind} {frame.parentJoint} " + " ".join(repr(float(number)) for number in numbers)


def main():
    description, base, output, *contacts = sys.argv[1:]
    root = [pinocchio.JointModelFreeFlyer()] if base == "floating" else []
    model = pinocchio.buildModelFromUrdf(description, *root)
    with open(output, "w") as file:
        file.writelines(line + "\n" for line in lines(model))
        file.writelines(placed(model, contact) + "\n" for contact in contacts)


if __name__ == "__main__":
    main()
