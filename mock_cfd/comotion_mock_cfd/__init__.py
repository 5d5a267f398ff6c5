"""A mock CFD client: hydrostatics, drag and added mass in place of a flow solver."""
