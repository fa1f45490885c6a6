//! Codes of faults in questions, and of warnings about starts that take the same look.

bksim_model::codes! {
    BAD_RANGE = "Q001", "values that cannot be read";
    UNKNOWN_NAME = "Q002", "a quantity that the model has not";
    N_DRIVES = "Q003", "more or fewer prescribed motions than free ones";
    NOT_REACHED = "Q004", "a pose that is not reached";
    NO_EQUILIBRIUM = "Q005", "no equilibrium";
    UNDETERMINED = "Q006", "unknowns that the equations do not determine";
    WITH_STATES = "Q007", "a question about a mechanism with states or clocks";
    UNDERCUT = "Q009", "a profile of a cam that is undercut";
    CUTTER = "Q010", "a cutter that does not fit into a hollow";
    UNKNOWN_CAM = "Q011", "a cam that the model has not";
    NOT_BALANCED = "Q012", "a start that no value balances";
    NOT_PLANAR = "Q013", "a question about planar mechanisms, asked of one in space";
    NO_ASSEMBLY = "Q014", "an assembly that there is not";
    THROUGH_STOP = "Q015", "a motion through a stop";
    NO_ACTUATOR = "Q016", "a motion that no actuator can meet";
    STOP_LETS_GO = "Q017", "a stop that would have to pull";
    FRICTION_JAMS = "Q018", "friction that no efforts are in balance with";
    DRIVE_REPLACED = "Q019", "a motion in place of that of a drive";
    GOES_NOWHERE = "Q020", "a start that yields, but goes nowhere";
    BRANCH_POINT = "Q021", "a pose in which branches cross";
    NOT_CLOSED = "Q022", "a start that no value closes";
    NO_NUMBER = "Q023", "a table with a value that is no number";
    NO_MOTION = "Q024", "a table that is no motion";
    BEYOND_TABLE = "Q025", "a motion that is asked for beyond its table";
    MOVING_INPUT = "Q030", "an input whose rates act, too";
    SINGULAR_START = "S026", "a run from a pose that yields, but goes nowhere";
    BRANCHES_AT_START = "S027", "a run from a pose in which branches cross";
    RATES_OFF_BRANCHES = "S034", "a start whose rates follow none of the branches that cross there";
}
