//! Codes of faults in requests for sweeps: here, so that they are explained without the crate that
//! sweeps.

bksim_model::codes! {
    pages "/docs/diagnostics/";
    BAD_AXIS = "P001", "an axis that spans nothing";
    UNKNOWN_AXIS = "P002", "an axis that nothing has";
    AXIS_TWICE = "P003", "an axis given twice";
    N_CASES = "P004", "too many cases, or none";
    UNKNOWN_OUTPUT = "P005", "an output that no run has";
    OTHER_SWEEP = "P006", "another sweep in the way";
    BAD_OPTION = "P007", "a setting out of range";
}
