!> Tests of what travels between images and into kept files: results of positions as words of 64
!> bits, their checksum, and the progress line.
module asperity_packet_suite
  use asperity_contact_records, only: contact_row, position_result, state_row
  use asperity_kept_records, only: checksum
  use asperity_kinds, only: int64, real64
  use asperity_position_packet, only: pack_position, unpack_position
  use asperity_progress, only: progress_text
  use asperity_testing, only: check, error_type, new_unittest, unittest_type
  implicit none
  private

  public :: collect_packets

contains

  !> Lists the tests.
  subroutine collect_packets(suite)
    !> all tests
    type(unittest_type), allocatable, intent(out) :: suite(:)

    suite = [ &
      new_unittest('checksum: published vectors', checksums), &
      new_unittest('a position as words', positions), &
      new_unittest('effects as words, with a list of contacts and without', effects), &
      new_unittest('progress in words', progress)]
  end subroutine collect_packets

  !> FNV-1a of 32 bits: test vectors of its authors, Fowler, Noll and Vo.
  subroutine checksums(error)
    type(error_type), allocatable, intent(out) :: error

    call check(error, checksum(''), '811C9DC5', 'of nothing')
    call check(error, checksum('a'), 'E40C292C', 'of a')
    call check(error, checksum('foobar'), 'BF9CF968', 'of foobar')
  end subroutine checksums

  subroutine positions(error)
    type(error_type), allocatable, intent(out) :: error
    type(position_result) :: sent, found
    integer(int64), allocatable :: words(:), again(:)

    sent%x_displacement = 0.1_real64
    sent%y_displacement = -tiny(1.0_real64)
    sent%limit_reached = .true.
    sent%overlapping_circles = 3
    sent%first_step_pressure = huge(1.0_real64)
    allocate (sent%states(2), sent%rows(4))
    sent%states(2) = state_row(1.0_real64, 2.0_real64, 3.0_real64, 5.0_real64, 6.0_real64, &
                               7.0_real64, 8.0_real64, 8.5_real64, 10.0_real64, 9.0_real64, 2, 4, &
                               1, 2, 11.0_real64, 12.0_real64, 13.0_real64, 14.0_real64)
    sent%rows(2) = contact_row(2, 3, 4, .true., 5.0_real64, 6.0_real64, 7.0_real64, 8.0_real64, &
                               9.0_real64, 10.0_real64, 11.0_real64, 12.0_real64, 13.0_real64, &
                               14.0_real64, 15.0_real64)
    ! More room than contacts.
    sent%rows_used = 2
    call pack_position(sent, words)
    call unpack_position(words, found)
    call check(error, found%limit_reached .and. found%overlapping_circles == 3, 'flags')
    call check(error, size(found%rows), 2, 'contacts')
    call check(error, found%rows(2)%limit_exceeded .and. found%rows(2)%lower == 4, 'a contact')
    call check(error, found%states(2)%contacts == 4 .and. found%states(2)%last_row == 2, 'a state')
    call check(error, found%states(2)%greatest_pressure > 8.0_real64, 'a pressure')
    call check(error, nint(found%states(2)%dissipated_work), 10, 'a work')
    call check(error, found%states(2)%prescribed == 2 .and. &
               nint(found%states(2)%prescribed_load) == 9, &
               'a load asked for')
    call pack_position(found, again)
    call check(error, size(again), size(words), 'how many words come back')
    if (allocated(error)) return
    call check(error, all(again == words), 'words that come back')
    call check(error, found%y_displacement < 0.0_real64, 'the smallest number')
    call check(error, .not. allocated(found%effects), 'no effects')
  end subroutine positions

  subroutine effects(error)
    type(error_type), allocatable, intent(out) :: error
    type(position_result) :: sent, found
    integer(int64), allocatable :: words(:)

    allocate (sent%states(1), sent%rows(0), sent%effects(2), sent%state_values(3))
    sent%state_values = [1.0_real64, 2.0_real64, 3.0_real64]
    sent%effects(1)%simulated = 'coupled+boundary'
    sent%effects(1)%why = 'contact circles overlap'
    sent%effects(1)%influence = -0.2_real64
    sent%effects(1)%ending%converged = .true.
    sent%effects(1)%ending%iterations = 12
    call pack_position(sent, words)
    call unpack_position(words, found)
    call check(error, found%effects(1)%simulated, 'coupled+boundary', 'how')
    call check(error, found%effects(1)%why, sent%effects(1)%why, 'why')
    call check(error, found%effects(1)%ending%converged .and. &
               found%effects(1)%ending%iterations == 12, 'how it ended')
    call check(error, trim(found%effects(2)%simulated), 'off', 'the other')
    call check(error, nint(sum(found%state_values)), 6, 'columns of the position')
    call check(error, size(found%contact_values), 0, 'no columns of contacts')
    allocate (sent%contact_values(2, 3))
    sent%contact_values = reshape([1.0_real64, 2.0_real64, 3.0_real64, 4.0_real64, 5.0_real64, &
                                   6.0_real64], [2, 3])
    call pack_position(sent, words)
    call unpack_position(words, found)
    call check(error, all(shape(found%contact_values) == [2, 3]), 'shape of the columns')
    call check(error, nint(found%contact_values(2, 3)), 6, 'the last contact''s last column')
    call check(error, nint(found%contact_values(2, 1)), 2, 'the last contact''s first column')
    call check(error, nint(sum(found%state_values)), 6, 'columns of the position, again')
  end subroutine effects

  subroutine progress(error)
    type(error_type), allocatable, intent(out) :: error

    call check(error, progress_text('positions', 50, 100, 0, 2.0_real64), &
               '50 of 100 positions, 25 a second, 2 s left', 'from the beginning')
    ! Half of it was done before: 25 in 2.5 s.
    call check(error, progress_text('positions', 75, 100, 50, 2.5_real64), &
               '75 of 100 positions, 10 a second, 3 s left', 'continued')
    call check(error, progress_text('surfaces', 3, 1003, 0, 90.0_real64), &
               '3 of 1003 surfaces, 2 a minute, 9 h left', 'hours')
  end subroutine progress

end module asperity_packet_suite
