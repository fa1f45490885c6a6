//! Codes of questions of design: optima, fits, tolerances, synthesis.

bksim_model::codes! { pages "/docs/diagnostics/";
    BAD_QUESTION = "O001", "a question of design that cannot be read";
    NOTHING_ASKED = "O002", "a question of design that the model does not state";
    UNKNOWN_QUANTITY = "O003", "a quantity of design that the model has not";
    NO_START = "O004", "no mechanism to begin with";
    BAD_DATA = "O005", "measured data that cannot be read";
    NOT_DETERMINED = "O006", "a pose that the question leaves open";
    NO_LINKAGE = "O007", "a task that no linkage does";
    UNMET = "O008", "conditions that nothing meets";
    NOT_ASSEMBLED = "O009", "a pose that is not assembled";
    LIMIT_THROUGH_ZERO = "O013", "limits of a length that go through zero";
}
