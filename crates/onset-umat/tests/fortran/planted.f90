! Neo-Hooke, W = mu/2 (I1 - 3) - mu ln J + lambda/2 (ln J)^2, correct except at states of one kind.
! PROPS = mu, lambda, kind, part, factor: part 1 multiplies DDSDDE, 2 its columns of shear, 3 its normal columns, 4 STRESS, 5 SSE.
subroutine umat(stress, statev, ddsdde, sse, spd, scd, rpl, ddsddt, drplde, drpldt, stran, &
    dstran, time, dtime, temp, dtemp, predef, dpred, cmname, ndi, nshr, ntens, nstatv, props, nprops, coords, &
    drot, pnewdt, celent, dfgrd0, dfgrd1, noel, npt, layer, kspt, jstep, kinc)
  implicit none
  integer :: ndi, nshr, ntens, nstatv, nprops, noel, npt, layer, kspt, jstep(4), kinc
  double precision :: stress(ntens), statev(nstatv), ddsdde(ntens, ntens), sse, spd, scd, rpl, ddsddt(ntens), drplde(ntens)
  double precision :: drpldt, stran(ntens), dstran(ntens), time(2), dtime, temp, dtemp, predef(1), dpred(1)
  double precision :: props(nprops), coords(3), drot(3, 3), pnewdt, celent, dfgrd0(3, 3), dfgrd1(3, 3)
  character(len=80) :: cmname
  double precision :: f(3, 3), b(3, 3), s(3, 3), d(3, 3), j, p, m, mu, la
  integer :: i, k, a, c, ii(6), jj(6)
  ii = [1, 2, 3, 1, 1, 2]; jj = [1, 2, 3, 2, 3, 3]
  mu = props(1); la = props(2)
  f = dfgrd1; b = matmul(f, transpose(f))
  d = 0; d(1, 1) = 1; d(2, 2) = 1; d(3, 3) = 1
  j = f(1, 1)*(f(2, 2)*f(3, 3) - f(2, 3)*f(3, 2)) - f(1, 2)*(f(2, 1)*f(3, 3) - f(2, 3)*f(3, 1)) &
    + f(1, 3)*(f(2, 1)*f(3, 2) - f(2, 2)*f(3, 1))
  p = la*log(j)
  s = (mu*(b - d) + p*d)/j
  m = mu - p
  do a = 1, 6
    do c = 1, 6
      i = ii(a); k = ii(c)
      ddsdde(a, c) = (la*d(i, jj(a))*d(k, jj(c)) + m*(d(i, k)*d(jj(a), jj(c)) + d(i, jj(c))*d(jj(a), k)))/j &
        + 0.5d0*(d(i, k)*s(jj(a), jj(c)) + d(jj(a), jj(c))*s(i, k) + d(i, jj(c))*s(jj(a), k) + d(jj(a), k)*s(i, jj(c)))
    end do
    stress(a) = s(ii(a), jj(a))
  end do
  sse = (mu/2*(b(1, 1) + b(2, 2) + b(3, 3) - 3) - mu*log(j) + la/2*log(j)**2)/j
  if (is_of_kind(nint(props(3)))) then
    select case (nint(props(4)))
    case (1); ddsdde = props(5)*ddsdde
    case (2); ddsdde(:, 4:6) = props(5)*ddsdde(:, 4:6)
    case (3); ddsdde(:, 1:3) = props(5)*ddsdde(:, 1:3)
    case (4); stress = props(5)*stress
    case (5); sse = props(5)*sse
    end select
  end if
contains
  logical function is_of_kind(kind)
    integer, intent(in) :: kind
    double precision, parameter :: small = 1d-9
    double precision :: dev(3, 3), square, cube, third
    logical :: aligned, one_axis, triple, double, rotated, isochoric
    third = (b(1, 1) + b(2, 2) + b(3, 3))/3
    dev = b - third*d
    square = sum(dev**2)/2
    cube = dev(1, 1)*(dev(2, 2)*dev(3, 3) - dev(2, 3)**2) - dev(1, 2)*(dev(1, 2)*dev(3, 3) - dev(2, 3)*dev(1, 3)) &
      + dev(1, 3)*(dev(1, 2)*dev(2, 3) - dev(2, 2)*dev(1, 3))
    triple = sqrt(square) < small
    ! Two eigenvalues of a deviator agree where 4 J2^3 = 27 J3^2.
    double = .not. triple .and. abs(4*square**3 - 27*cube**2) < 1d-10*square**3
    aligned = abs(b(1, 2)) + abs(b(1, 3)) + abs(b(2, 3)) < small
    one_axis = count([abs(b(1, 2)), abs(b(1, 3)), abs(b(2, 3))] > small) == 1
    rotated = sum(abs(f - transpose(f))) > small
    isochoric = abs(j - 1) < small
    select case (kind)
    case (1); is_of_kind = triple .and. isochoric
    case (2); is_of_kind = triple .and. isochoric .and. rotated
    case (3); is_of_kind = triple .and. j > 1 + small
    case (4); is_of_kind = triple .and. j < 1 - small
    case (5); is_of_kind = triple .and. .not. isochoric .and. rotated
    case (6); is_of_kind = double .and. aligned
    case (7); is_of_kind = double .and. .not. aligned
    case (8); is_of_kind = double .and. .not. aligned .and. rotated
    case (9); is_of_kind = double .and. cube > 0
    case (10); is_of_kind = double .and. cube < 0
    case (11); is_of_kind = double .and. aligned .and. abs(b(1, 1) - b(2, 2)) < small
    case (12); is_of_kind = double .and. aligned .and. abs(b(2, 2) - b(3, 3)) < small
    case (13); is_of_kind = double .and. aligned .and. abs(b(1, 1) - b(3, 3)) < small
    case (14); is_of_kind = double .and. isochoric
    case (15); is_of_kind = .not. (triple .or. double) .and. aligned
    case (16); is_of_kind = .not. (triple .or. double) .and. aligned .and. isochoric
    case (17); is_of_kind = .not. (triple .or. double) .and. aligned .and. rotated
    case (18); is_of_kind = one_axis
    case (19); is_of_kind = one_axis .and. abs(b(1, 2)) > small
    case (20); is_of_kind = one_axis .and. abs(b(1, 3)) > small
    case (21); is_of_kind = one_axis .and. abs(b(2, 3)) > small
    case (22); is_of_kind = .not. (triple .or. double .or. aligned .or. one_axis)
    case (23); is_of_kind = .not. (triple .or. double .or. aligned .or. one_axis) .and. rotated
    case (24); is_of_kind = .not. (triple .or. double .or. aligned .or. one_axis) .and. .not. rotated
    case (25); is_of_kind = .not. (triple .or. double .or. aligned .or. one_axis) .and. isochoric
    case (26); is_of_kind = isochoric .and. .not. triple
    case (27); is_of_kind = j > 1 + small
    case (28); is_of_kind = j < 1 - small
    case default; is_of_kind = .false.
    end select
  end function is_of_kind
end subroutine umat
