! Small strains, bulk modulus K and the secant shear modulus G0/(1 + gamma/g0) of a hyperbolic soil law; PROPS = K, G0, g0.
! DDSDDE is the secant stiffness, STRESS = DDSDDE : strain, and not a tangent.
subroutine umat(stress, statev, ddsdde, sse, spd, scd, rpl, ddsddt, drplde, drpldt, stran, &
    dstran, time, dtime, temp, dtemp, predef, dpred, cmname, ndi, nshr, ntens, nstatv, props, nprops, coords, &
    drot, pnewdt, celent, dfgrd0, dfgrd1, noel, npt, layer, kspt, jstep, kinc)
  implicit none
  integer :: ndi, nshr, ntens, nstatv, nprops, noel, npt, layer, kspt, jstep(4), kinc
  double precision :: stress(ntens), statev(nstatv), ddsdde(ntens, ntens), sse, spd, scd, rpl, ddsddt(ntens), drplde(ntens)
  double precision :: drpldt, stran(ntens), dstran(ntens), time(2), dtime, temp, dtemp, predef(1), dpred(1)
  double precision :: props(nprops), coords(3), drot(3, 3), pnewdt, celent, dfgrd0(3, 3), dfgrd1(3, 3)
  character(len=80) :: cmname
  double precision :: e(6), dev(6), v, g
  integer :: i
  e = stran + dstran
  v = sum(e(1:3))
  dev = e
  dev(1:3) = dev(1:3) - v/3
  g = props(2)/(1 + sqrt(2*(sum(dev(1:3)**2) + sum(dev(4:6)**2)/2))/props(3))
  ddsdde = 0
  ddsdde(1:3, 1:3) = props(1) - 2*g/3
  do i = 1, 6
    ddsdde(i, i) = ddsdde(i, i) + merge(2*g, g, i <= 3)
  end do
  stress = matmul(ddsdde, e)
end subroutine umat
