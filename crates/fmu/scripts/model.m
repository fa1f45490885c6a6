function s = @ID@()
% Equations of motion of @NAME@ for MATLAB and Octave.
%
%     q' = v
%     M(q) a + G(t, q)' lambda = f(t, q, v, u, l)
%     G a = -gamma(t, q, v),  g(t, q) = 0
%
%     s = @ID@();
%     [M, f, G, gamma, g, g_t] = s.terms(t, q, v, s.u, s.p);      % ..., s.p, l), l = lambda(s.pressing)
%     [a, lambda] = s.accelerations(t, q, v, s.u, s.p);
%     [t, x] = ode45(@(t, x) s.ode(t, x, s.u, s.p), [s.t0 1], [s.q0; s.v0]);
%     s.check()       % compares with numbers that bksim computed
%
% u are the inputs, p the parameters in the order of their names. All numbers are in SI units and radians.
@NOTES@s.coordinates = @COORDINATES@;
s.units = @UNITS@;
s.rates = @RATES@;
s.multipliers = @MULTIPLIERS@;
s.pressing = @PRESSING@;
s.inputs = @INPUTS@;
s.u = @U@;
s.parameters = @PARAMETERS@;
s.p = @P@;
s.t0 = @T0@;
s.q0 = @Q0@;
s.v0 = @V0@;
s.terms = @terms;
s.accelerations = @accelerations;
s.ode = @ode;
s.check = @check;
end

function [M, f, G, gamma, g, g_t, slopes] = terms(t, q, v, u, p, l)
% l are the multipliers that f depends on, slopes those of f by all multipliers.
mass = @MASS@;
jacobian = @JACOBIAN@;
s = @ID@();
n = numel(s.coordinates);
r = numel(s.multipliers);
if nargin < 6
    l = zeros(numel(s.pressing), 1);
end
values = entries([t; q(:); v(:); u(:); l(:)], p);
M = zeros(n, n);
G = zeros(r, n);
at = size(mass, 1);
for k = 1:at
    M(mass(k, 1), mass(k, 2)) = values(k);
    M(mass(k, 2), mass(k, 1)) = values(k);
end
f = values(at + (1:n));
at = at + n;
for k = 1:size(jacobian, 1)
    G(jacobian(k, 1), jacobian(k, 2)) = values(at + k);
end
at = at + size(jacobian, 1);
gamma = values(at + (1:r));
g = values(at + r + (1:r));
g_t = values(at + 2 * r + (1:r));
at = at + 3 * r;
slopes = zeros(n, r);
slopes(:, s.pressing) = reshape(values(at + 1:end), [], n)';
end

function [a, lambda] = accelerations(t, q, v, u, p)
% The stabilisation draws what integration leaves of g back to zero, 1/s.
stabilisation = 10;
[M, f, G, gamma, g, g_t] = terms(t, q, v, u, p);
n = size(M, 1);
s = @ID@();
aim = -gamma - 2 * stabilisation * (G * v(:) + g_t) - stabilisation ^ 2 * g;
found = [M, G'; G, zeros(size(G, 1))] \ [f; aim];
a = found(1:n);
lambda = found(n + 1:end);
% Newton's method to the multipliers that f depends on.
for round = 1:40 * ~isempty(s.pressing)
    [~, f, ~, ~, ~, ~, slopes] = terms(t, q, v, u, p, lambda(s.pressing));
    found = [M, G' - slopes; G, zeros(size(G, 1))] \ [f - slopes * lambda; aim];
    moved = max(abs(found(n + 1:end) - lambda));
    a = found(1:n);
    lambda = found(n + 1:end);
    if moved <= 1e-12 * max(abs(lambda))
        return
    end
    assert(round < 40, 'no multipliers that friction agrees with at %g s', t);
end
end

function x_rate = ode(t, x, u, p)
n = numel(x) / 2;
x_rate = [x(n + 1:end); accelerations(t, x(1:n), x(n + 1:end), u, p)];
end

function check()
inputs = @POINT_INPUTS@;
parameters = @POINT_PARAMETERS@;
outputs = @POINT_OUTPUTS@;
worst = 0;
for k = 1:size(inputs, 1)
    expected = outputs(k, :)';
    if any(isnan(expected))
        continue
    end
    found = entries(inputs(k, :)', parameters(k, :)');
    worst = max(worst, max(abs(found - expected) ./ (1e-3 * max(abs(expected)) + abs(expected))));
end
assert(worst < 1e-9, 'values differ by %g', worst);
motion = @MOTION@;
if isempty(motion)
    fprintf('values differ by %.1e; no motion is compared\n', worst);
else
    s = @ID@();
    options = odeset('RelTol', 1e-10, 'AbsTol', 1e-10);
    [~, x] = ode45(@(t, x) ode(t, x, s.u, s.p), [s.t0; motion(:, 1)], [s.q0; s.v0], options);
    expected = motion(:, 2:end);
    of_motion = max(max(abs(x(2:end, :) - expected) ./ (1 + abs(expected))));
    assert(of_motion < 1e-6, 'motion differs by %g', of_motion);
    fprintf('values differ by %.1e, motion by %.1e\n', worst, of_motion);
end
end

function y = select(condition, yes, no)
if condition ~= 0
    y = yes;
else
    y = no;
end
end

function values = entries(inputs, parameters)
@STATEMENTS@values = [@RESULTS@];
end
