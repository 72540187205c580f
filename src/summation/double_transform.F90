!> Convolutions of values of double precision, by Fourier transforms on a lattice padded with zeros.
!>
!> Rows are transformed one by one, without those of the padding; each column is transformed,
!> multiplied and transformed back by one thread: the bytes of the result do not depend on the
!> number of threads.
module asperity_double_transform
  use, intrinsic :: iso_c_binding, only: c_loc
  use asperity_kinds, only: int64, precision => real64, real64
  use asperity_line_transform, only: line_transform, real_to_waves, thread_threshold, waves_back, &
                                     waves_forward, waves_to_real
  implicit none
  private

  public :: padded_transform  !! transforms of one padded lattice

#include "padded_transform.inc"

end module asperity_double_transform
