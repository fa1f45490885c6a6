//! Codes of the faults of drawings, one row each; the page is what `bksim explain` prints.

bksim_model::codes! {
    // Files, containers, units.
    NOT_A_DRAWING = "D001", "not a drawing";
    TOO_LARGE = "D002", "a drawing too large";
    DAMAGED = "D003", "a damaged drawing";
    CUT = "D004", "a drawing cut off";
    ABSURD_NUMBER = "D005", "a number no drawing has";
    NO_UNITS = "D006", "a drawing without units";
    OTHER_UNITS = "D007", "units against those of the drawing";
    UNREADABLE = "D008", "a drawing that cannot be interpreted";
    BLOCK_IN_ITSELF = "D009", "a block within itself";
    NO_BLOCK = "D010", "an insert of no block";
    NO_BLOCK_END = "D076", "a block without an end";
    // Outlines and mass.
    OPEN_OUTLINE = "D020", "an open outline";
    AMBIGUOUS_ENDS = "D021", "ends that meet in more than one way";
    CROSSING_OUTLINES = "D022", "outlines that cross";
    DOUBLE_OUTLINE = "D023", "outlines on top of each other";
    NO_AREA = "D024", "an outline without area";
    NO_CURVE = "D025", "numbers that make no curve";
    SNAPPED = "D026", "a gap that was closed";
    DOUBLED = "D027", "an entity drawn twice";
    OUT_OF_PLANE = "D028", "an entity out of the plane";
    // Attachments.
    UNKNOWN_KIND = "D030", "nothing that can be attached";
    UNKNOWN_ATTRIBUTE = "D031", "an unknown key of an attachment";
    BROKEN_RECORD = "D032", "a broken record";
    NO_NAME = "D033", "an attachment without a name";
    DUPLICATE_NAME = "D034", "a name that is used twice";
    NO_PLACE = "D035", "an attachment without a place";
    UNKNOWN_PARTNER = "D036", "an unknown partner";
    NO_BODY_THERE = "D037", "no body at a point";
    AMBIGUOUS_PARTNERS = "D038", "more bodies at a point than a joint has";
    NO_JOINT_THERE = "D039", "no joint at a point";
    JOINT_SNAPPED = "D040", "two points taken as one";
    NOT_SNAPPED = "D041", "two points nearly at one place";
    AMBIGUOUS_SNAP = "D042", "two points of a body within the tolerance";
    NO_MASS = "D043", "a body without mass";
    NO_BODIES = "D044", "nothing is attached";
    DECIMAL_COMMA = "D045", "a decimal comma";
    STATED_TWICE = "D046", "stated twice";
    RENAMED = "D047", "names that are spelled otherwise";
    HIDDEN_LAYER = "D048", "a layer that is not shown";
    UNKNOWN_LAYER = "D049", "a layer that means nothing";
    UNREAD_KIND = "D050", "entities that are not read";
    SAYS_OTHERWISE = "D051", "a dimension that says otherwise";
    NOTHING_FOLLOWS = "D052", "a named length that nothing follows from";
    // Writing.
    NOT_THERE = "D060", "nothing there to edit";
    DOES_NOT_FIT = "D061", "a value the drawing cannot hold";
    BY_LAYER = "D062", "attached by its layer";
    WRITTEN_ANEW = "D063", "a drawing written again";
    NO_SUCH_KEY = "D064", "a key that the kind does not have";
    NAME_TAKEN = "D065", "a name that is taken";
    SPATIAL = "D070", "a spatial model cannot be drawn";
    UNDRAWABLE = "D071", "no place in a drawing";
    TOO_LONG = "D072", "does not fit into the release";
    NO_ROOM = "D073", "a drawing that nothing can be added to";
    UNKNOWN_POINT = "D074", "no such point in the run";
    OTHER_DRAWING = "D075", "a run of another drawing";
}
