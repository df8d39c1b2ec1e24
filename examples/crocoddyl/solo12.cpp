/// The Python module `solo12`: the quadruped's action models for Crocoddyl.
#include "solo12.hpp"
#include "python.hpp"

BOOST_PYTHON_MODULE(solo12) {
    modyn::python::expose<Solo12, solo12_link_names>();
    modyn::python::expose_contacts<Solo12, solo12_contact_names>();
}
